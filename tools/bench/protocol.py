"""The rover's serial protocol beside MAVLink 2: bytes, stepping in again after garbage, cost of the codec.

    python -m tools.bench protocol      # after `make setup-dev`, which brings pymavlink

Both sides are pure Python, so the times compare codecs and not languages. MAVLink messages are the nearest of its
`common` dialect; the content is the same where both have a place for it.
"""

from __future__ import annotations

import argparse
import itertools
import random
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import median
from typing import Any

from pymavlink.dialects.v20 import common as mavlink
from rover_protocol import framing, messages

SETPOINT_RATE = 50.0
KEEP_ALIVE_PERIOD = 0.1
BIT_ERROR_RATE = 1e-4


@dataclass(frozen=True)
class Resync:
    """What garbage costs: good frames lost after its end, and bytes until the first good frame begins, over trials."""

    frames_lost_mean: float
    frames_lost_worst: int
    bytes_median: float
    bytes_worst: int


class Rover:
    """This project's codec."""

    name = "rover"

    def __init__(self) -> None:
        self._sequence = 0

    def encode(self, name: str, **fields: int) -> bytes:
        message = messages.BY_NAME[name]
        frame = framing.encode(message.ID, self._sequence, message.pack(**fields))
        self._sequence = (self._sequence + 1) & 255
        return frame

    def sonar(self, number: int) -> bytes:
        return self.encode("Sonar", sensor=number % 3, status=0, range=200 + number % 3800, time=33_000 * number)

    @staticmethod
    def decoder() -> Callable[[bytes], list[Any]]:
        frames = framing.Decoder()

        def feed(data: bytes) -> list[Any]:
            return [messages.decode(identifier, payload) for identifier, _, payload in frames.feed(data)]

        return feed


class Mavlink:
    """MAVLink 2 without signing, as pymavlink does it."""

    name = "MAVLink 2"

    def __init__(self) -> None:
        self._link = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def pack(self, message: Any) -> bytes:
        frame = bytes(message.pack(self._link))
        self._link.seq = (self._link.seq + 1) & 255
        return frame

    def sonar(self, number: int) -> bytes:
        return self.pack(
            self._link.distance_sensor_encode(33 * number, 2, 400, 20 + number % 380, 1, number % 3, 0, 255)
        )

    def setpoint(self, at: float) -> bytes:
        """Position, velocity and heading at one moment."""
        return self.pack(
            self._link.set_position_target_local_ned_encode(
                int(at * 1e3), 1, 1, 1, 0b001111000000, 0.25 * at, 0.1, 0.0, 0.25, 0.01, 0.0, 0.1, 0.0, 0.0, 0.5, 0.1
            )
        )

    def heartbeat(self) -> bytes:
        return self.pack(self._link.heartbeat_encode(18, 8, 0, 0, 3))

    def timesync(self) -> bytes:
        return self.pack(self._link.timesync_encode(0, 1_234_567_890_123))

    def wheel_distance(self) -> bytes:
        return self.pack(self._link.wheel_distance_encode(1_234_567, 2, [1.25, 1.26] + [0.0] * 14))

    @staticmethod
    def decoder() -> Callable[[bytes], list[Any]]:
        link = mavlink.MAVLink(None)
        link.robust_parsing = True

        def feed(data: bytes) -> list[Any]:
            found = link.parse_buffer(data) or []
            return [message for message in found if message.get_type() not in ("BAD_DATA", "UNKNOWN")]

        return feed


def sizes() -> list[tuple[str, int, int]]:
    """(what, bytes of the rover's frame, bytes of MAVLink's) for messages of like content."""
    rover, other = Rover(), Mavlink()
    return [
        ("heartbeat", len(rover.encode("State", state=2, faults=1, arm_token=7, flags=9)), len(other.heartbeat())),
        ("clock request", len(rover.encode("ClockRequest", sequence=7)), len(other.timesync())),
        ("wheels", len(rover.encode("WheelTicks", time=1234, left=9550, right=9626)), len(other.wheel_distance())),
        ("sonar", len(rover.sonar(7)), len(other.sonar(7))),
    ]


def motion_rates() -> tuple[float, float]:
    """Bytes a second to command 1 m straight ahead: constant-jerk segments and keep-alives; set-points at 50 Hz."""
    speed, acceleration, jerk = 0.25, 0.5, 3.0
    duration = 1.0 / speed + speed / acceleration + acceleration / jerk
    rover = Rover()
    sent = len(rover.encode("SegmentStart", index=1, start_time=5_000_000))
    for index in range(1, 8):
        sent += len(rover.encode("SegmentTravel", index=index, duration=166_667, jerk_travel=3_000_000))
        sent += len(rover.encode("SegmentHeading", index=index, jerk_heading=0, flags=0))
    sent += int(duration / KEEP_ALIVE_PERIOD) * len(rover.encode("KeepAlive", counter=1))
    return sent / duration, SETPOINT_RATE * len(Mavlink().setpoint(1.0))


def segment_cost() -> tuple[int, int]:
    """(bytes on the serial line with framing, CAN frames) of one constant-jerk segment of both axes."""
    rover = Rover()
    halves = [
        rover.encode("SegmentTravel", index=513, duration=166_667, jerk_travel=3_000_001),
        rover.encode("SegmentHeading", index=513, jerk_heading=-4_000_001, flags=0),
    ]
    return sum(len(half) for half in halves), len(halves)


def sampled_rate() -> float:
    """Bytes a second of set-points at 50 Hz in the rover's own framing: travel and heading, then both speeds."""
    rover = Rover()
    position = rover.encode("ReferenceDistance", travel=25_000, heading=1_000_000)
    speed = rover.encode("Velocity", reference_travel=2500, reference_heading=100)
    return SETPOINT_RATE * (len(position) + len(speed))


def resync(side: type[Rover] | type[Mavlink], seed: int, trials: int) -> Resync:
    """Good frames, 1 to 300 random bytes, good frames again, into a fresh decoder each time."""
    chance = random.Random(seed)
    lost, silent = [], []
    for _ in range(trials):
        source = side()
        feed = side.decoder()
        before = [source.sonar(number) for number in range(3)]
        garbage = chance.randbytes(chance.randint(1, 300))
        after = [source.sonar(number) for number in range(3, 63)]
        assert len(feed(b"".join(before))) == 3
        feed(garbage)
        good = 0
        first: int | None = None
        for position, frame in enumerate(after):
            found = len(feed(frame))
            good += found
            if found and first is None:
                # A frame held back by the receiver comes out with a later one: what counts is when.
                first = sum(len(earlier) for earlier in after[:position])
        assert first is not None
        lost.append(len(after) - good)
        silent.append(first)
    return Resync(sum(lost) / trials, max(lost), median(silent), max(silent))


def through_noise(side: type[Rover] | type[Mavlink], seed: int, frames: int) -> float:
    """Share of frames that come through a line with random bit errors at BIT_ERROR_RATE."""
    chance = random.Random(seed)
    source = side()
    line = bytearray(b"".join(source.sonar(number) for number in range(frames)))
    position = -1
    while (position := position + 1 + int(chance.expovariate(BIT_ERROR_RATE))) < 8 * len(line):
        line[position // 8] ^= 1 << position % 8
    return len(side.decoder()(bytes(line))) / frames


def costs(frames: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Seconds to (encode, decode) one sonar message, median over repeats, both sides taken in turn."""
    taken: dict[str, list[tuple[float, float]]] = {}
    for _ in range(repeats):
        for side in (Rover, Mavlink):
            source, feed = side(), side.decoder()
            begin = time.perf_counter()
            line = [source.sonar(number) for number in range(frames)]
            middle = time.perf_counter()
            found = sum(len(feed(frame)) for frame in line)
            end = time.perf_counter()
            assert found == frames
            taken.setdefault(side.name, []).append(((middle - begin) / frames, (end - middle) / frames))
    return {name: (median(e for e, _ in pairs), median(d for _, d in pairs)) for name, pairs in taken.items()}


HEAD = (f"| | {Rover.name} | {Mavlink.name} | ratio |", "|---|--:|--:|--:|")


def byte_rows() -> Iterator[str]:
    """Rows of the comparison that count bytes."""
    for what, ours, theirs in sizes():
        yield f"| {what}, bytes | {ours} | {theirs} | {theirs / ours:.2f} |"
    segments, set_points = motion_rates()
    what = "1 m of motion, bytes/s: segments; set-points at 50 Hz"
    yield f"| {what} | {segments:.0f} | {set_points:.0f} | {set_points / segments:.0f} |"
    yield f"| the same in the rover's framing: set-points at 50 Hz | {sampled_rate():.0f} | | |"
    line, frames_on_bus = segment_cost()
    yield f"| one segment, bytes on serial (CAN frames) | {line} ({frames_on_bus}) | | |"


def noise_rows(seed: int, trials: int, frames: int) -> Iterator[str]:
    """Rows about garbage and bit errors."""
    mine, other = resync(Rover, seed, trials), resync(Mavlink, seed, trials)
    yield (
        f"| good frames lost after garbage, mean (worst) | {mine.frames_lost_mean:.2f} ({mine.frames_lost_worst}) "
        f"| {other.frames_lost_mean:.2f} ({other.frames_lost_worst}) | |"
    )
    yield (
        f"| bytes before the first good frame, median (worst) | {mine.bytes_median:.0f} ({mine.bytes_worst}) "
        f"| {other.bytes_median:.0f} ({other.bytes_worst}) | |"
    )
    shares = [through_noise(side, seed, frames) for side in (Rover, Mavlink)]
    yield f"| frames through bit errors at 10⁻⁴ | {shares[0]:.2%} | {shares[1]:.2%} | |"


def time_rows(frames: int, repeats: int) -> Iterator[str]:
    """Rows of processor time, relative to the rover's."""
    cost = costs(frames, repeats)
    for position, what in enumerate(("encode", "decode")):
        ratio = cost[Mavlink.name][position] / cost[Rover.name][position]
        yield f"| time to {what} a sonar message | 1 | {ratio:.2f} | {ratio:.2f} |"


def main(arguments: list[str]) -> int:
    """Prints the comparison."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench protocol", description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("bytes", "noise", "time"), action="append", help="these rows alone")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=2000, help="bursts of garbage")
    parser.add_argument("--frames", type=int, default=5000, help="frames through noise and for the timing")
    parser.add_argument("--repeats", type=int, default=7, help="timings of which the median counts")
    options = parser.parse_args(arguments)
    parts = {
        "bytes": byte_rows(),
        "noise": noise_rows(options.seed, options.trials, options.frames),
        "time": time_rows(options.frames, options.repeats),
    }
    for line in itertools.chain(HEAD, *(parts[name] for name in (options.only or parts))):
        print(line)
    return 0
