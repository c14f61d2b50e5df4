"""Segments arrive once, in order, whatever the wire loses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from rover.link.clock_estimate import ClockEstimate
from rover.link.session import Link
from rover.link.stream import SegmentStream
from rover.link.telemetry import MotionStatus
from rover_protocol import messages

from .listen import listen


@dataclass(frozen=True)
class Piece:
    duration_us: int = 100_000
    jerk_travel: int = 0
    jerk_heading: int = 0
    rest: bool = False


def pieces(count: int) -> list[Piece]:
    return [Piece(jerk_travel=n, rest=n == count - 1) for n in range(count)]


@pytest.fixture
def link(world) -> Link:
    link = Link(world, world)
    link.connect()
    link.arm()
    return link


def test_a_run_arrives_in_order_with_its_start_time(link, firmware) -> None:
    start = link.clock.now() + 0.5
    end = link.stream.begin(pieces(20), start)
    listen(link, 0.4)
    assert [entry[2] for entry in firmware.queue] == list(range(20))
    assert [entry[3] & 1 for entry in firmware.queue] == [1] + [0] * 19
    assert firmware.queue[-1][3] & 2
    assert end == pytest.approx(start + 2.0)
    assert firmware.starts[0] == pytest.approx(firmware.clock_us(start), abs=1500)
    assert (link.stream.sent, link.stream.repeated, link.stream.accepted) == (20, 0, 20)


def test_lost_halves_are_sent_again_and_nothing_is_taken_twice(link, firmware) -> None:
    rng = np.random.default_rng(3)
    firmware.drop = lambda name, count: name.startswith("Segment") and rng.random() < 0.2
    link.stream.begin(pieces(40), link.clock.now() + 3.0)
    listen(link, 2.8)
    assert [entry[2] for entry in firmware.queue] == list(range(40))
    assert link.stream.repeated > 0
    assert link.stream.unacknowledged == 0


def test_never_more_is_sent_than_the_firmware_has_room_for(link, firmware) -> None:
    firmware.capacity = 5
    listen(link, 0.1)
    link.stream.begin(pieces(12), link.clock.now() + 5.0)
    listen(link, 1.0)
    assert len(firmware.queue) == 5
    assert link.stream.sent == 5
    assert not link.stream.all_done


def test_indexes_wrap(world, firmware) -> None:
    firmware.next_index = 65_530
    link = Link(world, world)
    link.connect()
    link.arm()
    link.stream.begin(pieces(12), link.clock.now() + 0.5)
    listen(link, 0.4)
    assert [entry[0] for entry in firmware.queue] == [*range(65_530, 65_536), *range(6)]


def test_all_done_only_when_the_firmwares_queue_has_run_dry(link, firmware) -> None:
    link.stream.begin(pieces(3), link.clock.now() + 0.5)
    listen(link, 0.4)
    assert not link.stream.all_done
    firmware.queue.clear()
    listen(link, 0.1)
    assert link.stream.all_done


def test_a_start_that_was_missed_is_postponed(link, firmware) -> None:
    link.stream.begin(pieces(2), link.clock.now() + 0.2)
    firmware.drop = lambda name, count: name == "SegmentHeading"
    listen(link, 0.3)
    firmware.drop = lambda name, count: False
    listen(link, 0.4)
    assert len(firmware.queue) == 2
    assert link.stream.postponed >= 1


def test_after_a_latch_the_stream_goes_on_from_the_index_that_the_firmware_names(link, firmware) -> None:
    link.stream.begin(pieces(10), link.clock.now() + 0.5)
    listen(link, 0.06)
    link.stop(reason=3)
    listen(link, 0.5)
    assert link.state is not None
    assert (link.state.state, link.state.cause) == ("Latched", "StopCommand")
    taken = firmware.next_index
    link.arm()
    link.stream.begin([Piece(jerk_travel=777, rest=True)], link.clock.now() + 0.5)
    listen(link, 0.6)
    assert [(entry[0], entry[2], entry[3]) for entry in firmware.queue] == [(taken, 777, 3)]


def test_when_the_firmware_latches_by_itself_waiting_segments_are_forgotten(link, firmware) -> None:
    link.stream.begin(pieces(60), link.clock.now() + 0.5)
    listen(link, 0.04)
    firmware.flush(messages.STATE_LATCHED, messages.STATE_CAUSE_SONAR_GUARD)
    listen(link, 0.1)
    assert link.stream.unacknowledged == 0
    assert link.state is not None
    assert link.state.cause == "SonarGuard"


class Wire:
    """Hears what a stream sends; acknowledges when the test says so."""

    def __init__(self) -> None:
        self.taken: dict[int, int] = {}
        self.stream = SegmentStream(self.send, ClockEstimate())

    def send(self, name: str, **raw: int) -> None:
        if name == "SegmentTravel":
            before = self.taken.setdefault(raw["index"], raw["jerk_travel"])
            assert before == raw["jerk_travel"], "one index stands for two segments"

    def acknowledge(self, now: float, next_index: int) -> None:
        self.stream.on_status(MotionStatus(now, next_index, 64, 0, 0, 0))


def test_an_acknowledgement_later_than_the_repeat_gives_no_segment_a_second_index() -> None:
    wire = Wire()
    wire.acknowledge(0.0, 0)
    wire.stream.begin(pieces(40), 5.0)
    for step in range(3):
        wire.stream.service(0.02 * step)
    assert len(wire.taken) == 24
    wire.stream.service(0.2)
    assert wire.stream.repeated == 8, "the round begins anew with its first burst"
    wire.acknowledge(0.21, 20)
    wire.stream.service(0.22)
    wire.acknowledge(0.23, 24)
    for step in range(3):
        wire.stream.service(0.24 + 0.02 * step)
    assert wire.taken == {index: index for index in range(40)}


def test_an_acknowledgement_that_comes_late_takes_nothing_back() -> None:
    wire = Wire()
    wire.acknowledge(0.0, 0)
    wire.stream.begin(pieces(10), 5.0)
    wire.stream.service(0.0)
    wire.acknowledge(0.05, 6)
    wire.acknowledge(0.06, 3)
    wire.stream.service(0.07)
    assert wire.stream.unacknowledged == 4
    assert wire.taken == {index: index for index in range(10)}
