"""A bad wire does what it is told to, the same for the same seed, and to frames only what a wire can do."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from rover.link.disturbance import Disturbance, NoisyBytes, disturb
from rover.link.frames import Counters, Frame, FrameTransport
from rover.link.load import angle_of, compare, turns
from rover.motion.segment import duration_us


class Loop(FrameTransport):
    """What is sent comes back at once; time is the test's."""

    port = "loop"
    time_step = lead = 0.0
    last_heard = None
    bytes_written = bytes_read = 0
    counters = Counters()

    def __init__(self) -> None:
        self.time = 0.0
        self.waiting: list[Frame] = []

    def now(self) -> float:
        return self.time

    def wire_bytes(self, payload: int) -> float:
        return payload

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        return 0.0, 0.0

    def send(self, identifier: int, payload: bytes) -> None:
        self.waiting.append(Frame(self.time, identifier, payload))

    def receive(self) -> list[Frame]:
        frames, self.waiting = self.waiting, []
        return frames

    def close(self) -> None: ...


def carried(disturbance: Disturbance, seed: int = 1, count: int = 4000) -> list[int]:
    """Which of `count` numbered frames come back, in order, sent one a millisecond."""
    loop = Loop()
    wire = disturb(loop, disturbance, loop.now, seed)
    back: list[Frame] = []
    for number in range(count):
        loop.time = number * 1e-3
        wire.send(0x100, number.to_bytes(4, "little"))
        back += wire.receive()
    loop.time += 1.0
    back += wire.receive()
    back += wire.receive()
    return [int.from_bytes(frame.payload, "little") for frame in back]


def test_a_good_wire_changes_nothing() -> None:
    assert carried(Disturbance()) == list(range(4000))


def test_the_same_seed_is_the_same_wire() -> None:
    bad = Disturbance(drop=0.2, duplicate=0.1, delay=0.1, reorder=0.1, jitter=0.001)
    assert carried(bad, seed=5) == carried(bad, seed=5)
    assert carried(bad, seed=5) != carried(bad, seed=6)


def test_frames_are_lost_at_the_rate_that_was_asked_for_each_way() -> None:
    assert len(carried(Disturbance(drop=0.2))) == pytest.approx(4000 * 0.8**2, rel=0.05)


def test_a_wrong_bit_costs_a_bus_the_frame() -> None:
    bits = 47 + 4 * 8
    assert len(carried(Disturbance(bit_error_rate=1e-3))) == pytest.approx(4000 * 0.999 ** (2 * bits), rel=0.05)


def test_a_doubled_frame_comes_twice() -> None:
    back = carried(Disturbance(duplicate=0.1))
    assert set(back) == set(range(4000))
    assert len(back) == pytest.approx(4000 * 1.1**2, rel=0.05)


@pytest.mark.parametrize("bad", [Disturbance(delay=0.1), Disturbance(reorder=0.1)])
def test_late_and_overtaken_frames_come_once_and_behind_others(bad: Disturbance) -> None:
    back = carried(bad)
    assert len(back) == len(set(back)) >= 3995, "at most the last few have nothing behind them"
    backwards = sum(b < a for a, b in itertools.pairwise(back))
    assert backwards > 200


def test_jitter_makes_the_senders_stamp_earlier_and_the_receivers_later() -> None:
    loop = Loop()
    wire = disturb(loop, Disturbance(jitter=0.001), loop.now, 3)
    leads, lags = [], []
    for number in range(500):
        loop.time = number * 0.01
        wire.send(1, b"")
        leads.append(wire.lead)
        sent = loop.time
        loop.time += 0.002
        lags += [frame.time - sent for frame in wire.receive()]
    assert -0.001 <= min(leads) < -0.0009
    assert -0.0001 < max(leads) <= 0.0
    assert 0.0 <= min(lags) < 0.0001
    assert 0.0009 < max(lags) <= 0.001


def test_wrong_bits_on_a_line_come_at_their_rate(world) -> None:
    noisy = NoisyBytes(world, 1e-3, np.random.default_rng(2))
    world.inbox = [(0.0, bytes(100_000))]
    ((_, data),) = noisy.read()
    wrong = sum(byte.bit_count() for byte in data)
    assert wrong == noisy.flipped == pytest.approx(800, rel=0.1)


def test_turns_stay_in_place_and_end_at_rest() -> None:
    block = turns(40, np.random.default_rng(1))
    assert abs(sum(map(angle_of, block))) < 0.6
    assert all(turn[0].begin and turn[-1].rest for turn in block)
    assert all(segment.duration_us <= 20_000 for turn in block for segment in turn)
    assert 0.2e6 < duration_us(block[0]) < 1.0e6


def test_what_the_firmware_has_turned_tells_what_was_lost_or_repeated() -> None:
    block = turns(8, np.random.default_rng(1))
    whole = sum(map(angle_of, block))
    assert compare(block, whole + 2e-6) == (0, 0)
    for turn in block:
        assert compare(block, whole - angle_of(turn)) == (len(turn), 0)
        assert compare(block, whole + angle_of(turn)) == (0, len(turn))
    assert compare(block, whole + 0.01) == (sum(map(len, block)), 0), "what cannot be explained is not called good"
