"""The emulated board with the firmware that is flashed: pins in, pins out."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput, PreflightFailed
from rover_hil.firmware_process import find_elf
from rover_protocol.rig_tick import NO_SENSOR, TickRequest

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator import wiring
from rover_hil.emulator.board import TICK_CYCLES, Board
from rover_hil.emulator.chip import Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.quadrature import edges
from rover_hil.emulator.tick_pipe import Reply, Request

pytestmark = pytest.mark.rig("emulator")

TIMER_1, SOFTWARE_1 = 1, 27
"""Interrupts in which the control loop may run."""


class Bench:
    """A board that has booted, and ticks."""

    def __init__(self, elf: Path) -> None:
        self.chip = Chip()
        self.board = Board(self.chip)
        self.chip.load(flash_segments(elf))
        self.now = 0

    def tick(self, counts: tuple[int, int] = (0, 0), ping: tuple[int, int] | None = None, stop: bool = False) -> None:
        request = Request(self.now // 125, counts, 7400, stop, 0, ping)
        self.board.apply(request, self.now)
        self.now += TICK_CYCLES
        self.chip.run_until(self.now)


@pytest.fixture
def bench() -> Bench:
    try:
        elf = find_elf()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    return Bench(elf)


def test_every_edge_of_the_encoders_is_counted_by_the_pio(bench: Bench) -> None:
    generator = np.random.default_rng(4)
    counts = np.zeros(2, dtype=int)
    for _ in range(20):
        bench.tick()
    for _ in range(200):
        # Five a millisecond are more than the motors turn the wheels at full duty.
        counts = counts + generator.integers(-5, 6, 2)
        bench.tick((int(counts[0]), int(counts[1])))
    bench.tick((int(counts[0]), int(counts[1])))
    machines = bench.chip.pio[0].machines
    signed = [machine.y - (machine.y >> 31 << 32) for machine in machines[:2]]
    bench.chip.encoder_pio.catch_up()
    assert signed == counts.tolist()


def test_skipped_rounds_of_the_pio_leave_the_state_that_stepping_would_have_left(bench: Bench) -> None:
    for _ in range(20):
        bench.tick()
    lazy = bench.chip.encoder_pio
    block = bench.chip.pio[0]
    before = [(m.pc, m.x, m.y, m.next_due_fp - block.cycle_fp) for m in block.machines[:2]]
    period = lazy._loop
    assert period > 0, "both machines wait in a loop"
    lazy._run(block.cycle_fp + 7 * period)
    assert [(m.pc, m.x, m.y, m.next_due_fp - block.cycle_fp) for m in block.machines[:2]] == before


def test_a_triggered_sonar_gets_its_echo_and_the_next_one_its_turn(bench: Bench) -> None:
    triggered: list[int] = []
    ping = None
    for _ in range(300):
        bench.tick(ping=ping)
        sensor = bench.board.take_trigger()
        ping = None if sensor is None else (sensor, 5800)
        triggered += [] if sensor is None else [sensor]
    assert len(triggered) >= 6
    assert sorted(triggered[:3]) == [0, 1, 2]
    assert triggered[3:6] == triggered[:3]


def test_a_disarmed_board_keeps_the_bridge_asleep(bench: Bench) -> None:
    for _ in range(50):
        bench.tick()
        assert not bench.board.output(wiring.STANDBY)


def test_the_watchdog_restarts_a_board_whose_control_loop_has_died(bench: Bench) -> None:
    for _ in range(50):
        bench.tick()
    # Its interrupt is taken away as no program would: only the hardware can help now.
    for interrupt in (TIMER_1, SOFTWARE_1):
        bench.chip.processor.disable_interrupt(interrupt)
    began = bench.now
    while not bench.chip.watchdog._reason and bench.now < began + 300 * TICK_CYCLES:
        bench.tick()
    assert bench.chip.watchdog._reason == 1, "by its timer"
    assert 60 <= (bench.now - began) / TICK_CYCLES <= 130
    for _ in range(100):
        bench.tick()
    assert bench.chip.watchdog._reason == 1, "kept for the next start to read"


def test_edges_are_spread_inside_the_millisecond_and_change_one_pin_at_a_time() -> None:
    there = list(edges(3, 8, 1000, 2000))
    assert [cycle for cycle, _, _ in there] == [1100, 1300, 1500, 1700, 1900]
    levels = [(a, b) for _, a, b in there]
    assert all((a1 != a2) != (b1 != b2) for (a1, b1), (a2, b2) in pairwise(levels))
    assert list(edges(5, 5, 0, 1000)) == []


def test_a_request_carries_the_ping_and_a_reply_has_its_bytes() -> None:
    data = TickRequest(7, -1, 2, 0, 7400, NO_SENSOR, 1, 9, 2, 1, 1, 5800, 4, -5, 6, 7, -8, 9, -10).pack()
    assert len(data) == TickRequest.SIZE
    request = Request.unpack(data)
    assert request == Request(7, (-1, 2), 7400, True, 9, (1, 5800), True, 1, (4, -5, 6), (7, -8, 9), -10)
    reply = Reply((-1.0, 1.0), True, False, True, None, 3).pack()
    assert reply == b"\x00\x80\xff\x7f\x05\xff\x00\x00\x03\x00\x00\x00\x00\x00\x00\x00"


def test_a_file_that_is_no_firmware_is_refused_in_one_line(tmp_path: Path) -> None:
    for name, data in {"empty.elf": b"", "text.elf": b"hello" * 40}.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(BadInput, match=name):
            flash_segments(tmp_path / name)
    with pytest.raises(BadInput, match="make firmware"):
        flash_segments(tmp_path / "missing.elf")
