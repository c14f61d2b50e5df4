"""Motion over lines that lose, repeat, delay, reorder and spoil: no segment lost, repeated or executed twice."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import TypeVar

import pytest
from rover_protocol import framing, messages
from rover_protocol.message import Message

from protocol.tests.firmware_process import CanText, Conversation

SEGMENTS = 160
LOSS = 0.2
BIT_ERROR_RATE = 1e-4
WINDOW = 16
REPEAT_MS = 60
DAMAGED = ("checksum_errors", "malformed", "lost")

Frame = TypeVar("Frame")


def pieces(count: int) -> list[tuple[int, int, int, int]]:
    """(duration µs, jerk of travel, jerk of heading, flags): `count` humps of speed, a multiple of four, then rest."""
    shape = (1, -1, -1, 1)
    return [
        (90_000 + 7 * i, 2_000_000 * shape[i % 4], -3_000_000 * shape[i % 4], (i == 0) | (i == count - 1) << 1)
        for i in range(count - count % 4)
    ]


class BadLine:
    """Frames both ways, each lost, doubled or delayed by up to 30 ms (which reorders), by a seed."""

    def __init__(self, talk: Conversation, seed: int) -> None:
        self._talk, self._chance = talk, random.Random(seed)
        self._up: list[tuple[int, bytes]] = []
        self._down: list[tuple[int, tuple[int, bytes]]] = []
        self.lost = self.doubled = 0

    def send(self, message: Message, /, **fields: int) -> None:
        self._up += self._fate(self._talk.text.encode(message.ID, message.pack(**fields)))

    def run(self, milliseconds: int) -> None:
        firmware = self._talk.firmware
        for _ in range(milliseconds):
            self._up, due = self._split(self._up)
            firmware.send(b"".join(due))
            for frame in self._talk.text.decode(firmware.tick()):
                self._down += self._fate(frame)
            self._down, arrived = self._split(self._down)
            self._talk.hear(arrived)

    def _fate(self, frame: Frame) -> Iterator[tuple[int, Frame]]:
        copies = self._chance.choices((0, 1, 2), (LOSS, 0.9 - LOSS, 0.1))[0]
        self.lost += copies == 0
        self.doubled += copies == 2
        for _ in range(copies):
            delay = self._chance.randrange(30) if self._chance.random() < 0.3 else 0
            yield self._talk.firmware.now_us + 1000 * delay, frame

    def _split(self, waiting: list[tuple[int, Frame]]) -> tuple[list[tuple[int, Frame]], list[Frame]]:
        now = self._talk.firmware.now_us
        return [w for w in waiting if w[0] > now], [frame for due, frame in waiting if due <= now]


class NoisyLine(BadLine):
    """Bytes both ways with independent bit errors."""

    def run(self, milliseconds: int) -> None:
        firmware = self._talk.firmware
        for _ in range(milliseconds):
            self._up, due = self._split(self._up)
            firmware.send(self._spoil(b"".join(due)))
            self._talk.hear(self._talk.text.decode(self._spoil(firmware.tick())))

    def _fate(self, frame: Frame) -> Iterator[tuple[int, Frame]]:
        yield self._talk.firmware.now_us, frame

    def _spoil(self, data: bytes) -> bytes:
        spoiled = bytearray(data)
        for bit in range(8 * len(spoiled)):
            if self._chance.random() < BIT_ERROR_RATE:
                spoiled[bit // 8] ^= 1 << bit % 8
                self.lost += 1
        return bytes(spoiled)


Line = TypeVar("Line", bound="BadLine | Conversation")


def stream(talk: Conversation, line: BadLine | Conversation, run: list[tuple[int, int, int, int]]) -> list[int]:
    """Arms, streams the run by acknowledgement and repetition, waits for its end. The indices as they were executed."""
    last = talk.last
    start = None
    moved, next_index, token = 0, 0, 0
    executed: list[int] = []
    for ms in range(30_000):
        now = talk.firmware.now_us
        state = last.get("State", {})
        if ms % 50 == 0:
            line.send(messages.KeepAlive, counter=ms // 50 & 255)
        if ms % 40 == 0 and not state.get("flags", 0) & 1:
            line.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=1)
        elif ms % 40 == 0 and state.get("state") == messages.STATE_DISARMED and now > 100_000:
            token += 1
            line.send(messages.Arm, token=token, session=1)
        armed = state.get("state") in (messages.STATE_ARMED, messages.STATE_MOVING)
        status = last.get("MotionStatus")
        if armed and status:
            start = start or now + 900_000
            if status["next_index"] != next_index:
                moved, next_index = ms, status["next_index"]
            if ms - moved >= REPEAT_MS or (moved == ms) or (next_index == 0 and moved == 0):
                moved = ms
                if next_index == 0:
                    line.send(messages.SegmentStart, index=0, start_time=start & 0xFFFFFFFF)
                for index in range(next_index, min(next_index + WINDOW, len(run))):
                    duration, travel, heading, flags = run[index]
                    line.send(messages.SegmentTravel, index=index, duration=duration, jerk_travel=travel)
                    line.send(messages.SegmentHeading, index=index, jerk_heading=heading, flags=flags)
            if state.get("state") == messages.STATE_MOVING and executed[-1:] != [status["executing"]]:
                executed.append(status["executing"])
            if status["executing"] == len(run) - 1 and status["queued"] == 0:
                break
        line.run(1)
    for later in range(1, 31):
        line.send(messages.KeepAlive, counter=(ms // 50 + later) & 255)
        line.run(50)
    return executed


def end_of(
    run: list[tuple[int, int, int, int]], line_of: Callable[[Conversation], Line], wire: str
) -> tuple[dict[str, dict[str, int]], dict[str, int], list[int], Line]:
    """(last messages, counters of the firmware, executed indices, the line) after the run over a line."""
    talk = Conversation(wire)
    line = line_of(talk)
    try:
        executed = stream(talk, line, run)
        return talk.last, talk.last["LinkStatistics"], executed, line
    finally:
        talk.close()


@pytest.fixture(scope="module")
def wanted() -> dict[str, int]:
    """Where a run over a good line ends."""
    last, _, _, _ = end_of(pieces(SEGMENTS), lambda talk: talk, "serial")
    return last["ReferenceDistance"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_frames_lost_doubled_delayed_and_reordered_on_the_bus_change_nothing(wanted: dict[str, int], seed: int) -> None:
    run = pieces(SEGMENTS)
    last, _, _, line = end_of(run, lambda talk: BadLine(talk, seed), "can")
    assert line.lost > 100
    assert line.doubled > 50
    assert last["ReferenceDistance"] == wanted
    assert (last["MotionStatus"]["next_index"], last["MotionStatus"]["rejected"]) == (len(run), 0)
    assert last["State"]["state"] == messages.STATE_ARMED


@pytest.mark.parametrize("seed", [1, 2])
def test_bit_errors_on_the_serial_line_cost_repetitions_and_counters_and_nothing_else(
    wanted: dict[str, int], seed: int
) -> None:
    run = pieces(SEGMENTS)
    last, counters, executed, line = end_of(run, lambda talk: NoisyLine(talk, seed), "serial")
    assert line.lost > 5
    assert sum(counters[name] for name in DAMAGED) > 0
    assert last["ReferenceDistance"] == wanted
    assert last["MotionStatus"]["next_index"] == len(run)
    assert executed == sorted(set(executed)), "each once, in order"
    assert last["State"]["state"] == messages.STATE_ARMED


def malformed() -> Iterator[tuple[int, bytes]]:
    """Every identifier of the companion with every wrong length, identifiers of nobody, the rover's own messages."""
    for identifier, message in messages.BY_ID.items():
        yield from ((identifier, bytes(n)) for n in range(9) if n != message.LENGTH)
    yield from ((identifier, b"\1" * 8) for identifier in range(0x800) if identifier not in messages.BY_ID)
    yield messages.TestMode.ID, messages.TestMode.pack(enable=1, key=0x5446)
    yield messages.TestMode.ID, messages.TestMode.pack(enable=2, key=0x5445)
    yield messages.InjectWheels.ID, bytes(8)
    yield messages.State.ID, bytes([5, 1, 0, 0, 0, 0, 0, 0])


@pytest.mark.parametrize("wire", ["serial", "can"])
def test_no_malformed_frame_has_an_effect_other_than_a_counter(wire: str) -> None:
    talk = Conversation(wire)
    try:
        talk.arm()
        talk.send(messages.TelemetryRate, message=messages.LinkStatistics.ID, period=50)
        talk.run(150)
        before = {name: dict(talk.last[name]) for name in ("State", "MotionStatus", "ReferenceDistance")}
        counted = talk.last["LinkStatistics"]["malformed"]
        talk.heard.clear()
        sent = 0
        for identifier, payload in malformed():
            if wire == "can" and identifier > 0x7FF:
                continue
            talk.firmware.send(talk.text.encode(identifier, payload))
            sent += 1
            talk.run(1)
            if sent % 40 == 0:
                talk.send(messages.KeepAlive, counter=sent // 40 & 255)
        talk.run(120)
        assert {name: talk.last[name] for name in before} == before
        assert talk.last["LinkStatistics"]["malformed"] - counted == sent
        assert {name for name, _ in talk.heard} <= TELEMETRY
        assert talk.firmware.powered
    finally:
        talk.close()


TELEMETRY = {
    *("State", "MotionStatus", "WheelTicks", "OdometryPosition", "OdometryHeading", "Velocity"),
    *("ReferenceDistance", "Battery", "MotorDuty", "LinkStatistics", "Sonar"),
}


def test_a_frame_with_a_wrong_checksum_is_counted_and_does_nothing() -> None:
    talk = Conversation("serial")
    try:
        talk.arm()
        for n in range(200):
            stop = bytearray(framing.encode(messages.EmergencyStop.ID, n, b"\x07"))
            stop[6] ^= 1 + n % 5
            talk.firmware.send(bytes(stop))
            talk.run(1)
        talk.send(messages.KeepAlive, counter=9)
        talk.run(900)
    finally:
        talk.close()
    assert talk.last["LinkStatistics"]["checksum_errors"] + talk.last["LinkStatistics"]["malformed"] == 200
    assert talk.last["State"]["cause"] == messages.STATE_CAUSE_DEAD_MAN, "nothing but the silence stopped it"


def test_lines_of_the_adapter_that_are_spoiled_are_refused() -> None:
    talk = Conversation("can")
    try:
        talk.arm()
        for n in range(100):
            line = bytearray(CanText.encode(messages.EmergencyStop.ID, b"\x07"))
            line[n % 4] = 0x47
            talk.firmware.send(bytes(line))
            talk.run(1)
        assert talk.firmware.powered
    finally:
        talk.close()
