"""The same inputs to the core on the desktop and to the flashed ELF, compared tick by tick.

What makes the inputs of a tick the same:

- The chip's loop ticks at times of its own, counted from its power-on. rover-sitl gets exactly those times, and the
  board's millisecond ends `LEAD_US` before each, so that edges and bytes of a tick have all come when it begins.
- The battery is held at one voltage: the converter's steps and its averaging are the board's own.
- Echoes have lengths in the middle of the millimetre that the core rounds to, and end in the middle of a tick; both
  sides hear each in the tick after its end. The lengths themselves are the recorded ones.

Outputs of a tick are those that the pins show before the next one begins.
"""

from __future__ import annotations

import math
import socket
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from rover_hil.emulator import wiring
from rover_hil.emulator.board import BURST_US, TICK_CYCLES, Board
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.tick_pipe import NO_SENSOR, REPLY, REQUEST, Request
from rover_hil.emulator.wire import SerialWire
from rover_hil.firmware_process import FirmwareProcess
from rover_hil.tick_recorder import Tick

TICK_US = 1000
LEAD_US = 20
CONTROL_ALARM = 1
"""Alarm of the timer that the control loop sets to its next tick."""
PWM_STEPS = 6250
FALL_TIMEOUT_US = 25_000
"""After which the firmware stops waiting for the end of an echo."""
BOOT_LIMIT_US = 200_000


@dataclass(frozen=True)
class Outputs:
    """What a tick leads to. Duties in steps of the PWM, as the bridge sees them."""

    duty: tuple[int, int]
    powered: bool
    led: bool
    buzzer: bool
    trigger: int | None


@dataclass(frozen=True)
class Compared:
    """One tick on both."""

    tick: int
    time_us: int
    sitl: Outputs
    board: Outputs


def snap(echo_us: int, millimetre_us: float = 2e3 / 343.0) -> int:
    """The nearest length that both sides round to the same millimetre and hear in the same tick, µs."""
    millimetre = round(echo_us / millimetre_us)
    while True:
        centre = round(millimetre * millimetre_us)
        if 200 <= (BURST_US - LEAD_US + centre) % TICK_US <= 800:
            return centre
        millimetre += 1


class _Bench:
    """The emulated board, aligned with its own ticks."""

    def __init__(self, elf: Path, baud: int) -> None:
        self.chip = Chip()
        self.board = Board(self.chip)
        self.host, far_end = socket.socketpair()
        self._far_end = far_end
        self.wire = SerialWire(self.chip, far_end.fileno(), baud)
        self.chip.load(flash_segments(elf))
        self.sent = bytearray()
        self.now = 0

    def boot(self, first: Request) -> int:
        """Until the control loop has set its first tick; returns that time, µs."""
        self.board.apply(replace(first, ping=None), 0)
        while not (target := self.chip.core.timer_targets[CONTROL_ALARM]):
            self.now += CYCLES_PER_US
            if self.now > BOOT_LIMIT_US * CYCLES_PER_US:
                raise RuntimeError("the control loop did not start")
            self.chip.run_until(self.now)
        return target

    def step(self, request: Request, host: bytes, end_us: int) -> Outputs:
        """One millisecond that ends `LEAD_US` before a tick; returns the outputs of the tick before."""
        end = (end_us - LEAD_US) * CYCLES_PER_US
        start = max(end - TICK_CYCLES, self.now)
        self.board.apply(request, start)
        self.host.sendall(host)
        self.wire.receive(request.host_bytes_due, start)
        self.chip.run_until(end)
        self.now = end
        self.wire.transmit()
        self.host.setblocking(False)
        try:
            while part := self.host.recv(4096):
                self.sent += part
        except BlockingIOError:
            self.host.setblocking(True)
        left, right = self.board.duty
        return Outputs(
            (round(left * PWM_STEPS), round(right * PWM_STEPS)),
            self.board.output(wiring.STANDBY),
            self.board.output(wiring.LED),
            self.board.output(wiring.BUZZER),
            self.board.take_trigger(),
        )

    def close(self) -> None:
        self.host.close()
        self._far_end.close()


class Conformance:
    """Compares a recording's ticks on both; afterwards `sitl_bytes` and `board_bytes` hold what each has sent."""

    def __init__(self, elf: Path, sitl: list[str], battery_mv: int = 7400, baud: int = 230_400) -> None:
        self._elf, self._sitl, self._baud = elf, sitl, baud
        # What the board's converter makes of the voltage.
        steps = int(battery_mv / wiring.BATTERY_DIVIDER / wiring.ADC_REFERENCE_MV * wiring.ADC_STEPS)
        step_mv = wiring.ADC_REFERENCE_MV * wiring.BATTERY_DIVIDER / wiring.ADC_STEPS
        self._battery_mv, self._read_mv = battery_mv, int(steps * step_mv)
        self.sitl_bytes = bytearray()
        self.board_bytes = bytearray()

    def run(self, ticks: Iterable[Tick]) -> Iterator[Compared]:
        """One comparison for each tick."""
        ticks = list(ticks)
        lengths: list[deque[int]] = [deque() for _ in wiring.SONARS]
        for tick in ticks:
            if tick.request.ping is not None:
                lengths[tick.request.ping[0]].append(tick.request.ping[1])
        bench = _Bench(self._elf, self._baud)
        process = FirmwareProcess(self._sitl, self._baud)
        try:
            yield from self._compare(ticks, lengths, bench, process)
            self.board_bytes = bench.sent
        finally:
            process.close()
            bench.close()

    def _compare(
        self, ticks: list[Tick], lengths: list[deque[int]], bench: _Bench, process: FirmwareProcess
    ) -> Iterator[Compared]:
        first_us = bench.boot(replace(ticks[0].request, battery_mv=self._battery_mv))
        echoes: dict[int, tuple[int, int]] = {}
        ping: tuple[int, int] | None = None
        expected: Outputs | None = None
        due = 0
        for index, tick in enumerate(ticks):
            due += len(tick.host)
            now_us = first_us + index * TICK_US
            request = replace(tick.request, now_us=now_us, battery_mv=self._battery_mv, host_bytes_due=due, ping=ping)
            board = bench.step(request, tick.host, now_us)
            if expected is not None:
                yield Compared(index - 1, now_us - TICK_US, expected, board)
            expected = self._tick_sitl(
                process, replace(request, battery_mv=self._read_mv), tick.host, echoes.pop(index, None)
            )
            ping = None
            if expected.trigger is not None:
                sensor = expected.trigger
                recorded = lengths[sensor].popleft() if lengths[sensor] else 0
                echo_us = snap(recorded) if recorded else 0
                ping = (sensor, echo_us)
                # The board hears of it in the next millisecond, which begins LEAD_US before its tick.
                ends_us = BURST_US - LEAD_US + (echo_us or FALL_TIMEOUT_US)
                echoes[index + 1 + math.ceil(ends_us / TICK_US)] = ping

    def _tick_sitl(
        self, process: FirmwareProcess, request: Request, host: bytes, echo: tuple[int, int] | None
    ) -> Outputs:
        process.send(host)
        sensor, echo_us = echo or (NO_SENSOR, 0)
        left, right = request.counts
        process.stdin.write(
            REQUEST.pack(
                request.now_us, left, right, echo_us, request.battery_mv, sensor,
                request.emergency_stop, request.host_bytes_due, 0, 0,
            )
        )  # fmt: skip
        process.stdin.flush()
        duty_left, duty_right, flags, trigger, total = REPLY.unpack(process.stdout.read(REPLY.size))
        self.sitl_bytes += process.receive(total - len(self.sitl_bytes))
        return Outputs(
            (_steps(duty_left), _steps(duty_right)),
            bool(flags & 1),
            bool(flags & 2),
            bool(flags & 4),
            None if trigger == NO_SENSOR else trigger,
        )


def _steps(duty: int) -> int:
    """The board's PWM steps for a duty in Q15: cut off towards zero."""
    return int(math.copysign(abs(duty) * PWM_STEPS >> 15, duty)) if duty else 0
