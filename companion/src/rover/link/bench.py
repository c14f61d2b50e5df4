"""The link under load: segments at fifty a second over a wire as bad as wanted, and what came of them.

What was lost or repeated is measured at the far end: the firmware tells which index it executed last, and how far its
reference has turned, which is a sum over every segment that it has executed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rover_protocol import messages

from rover.errors import LinkLost, SafetyStop
from rover.link.clock import Clock
from rover.link.disturbance import Disturbance, DisturbedFrames, disturb
from rover.link.frames import FrameTransport
from rover.link.load import Executed, Turn, compare, turns
from rover.link.session import DRIVEABLE, STEP_S, Link
from rover.link.statistics import percentile
from rover.link.telemetry import Telemetry

# Turns between two comparisons of what was sent with what was executed: five to six seconds.
TURNS_IN_A_BLOCK = 8

# Seconds ahead at which a block begins, as motion of a mission does.
LEAD_S = 0.5

# Seconds between two turns.
PAUSE_S = 0.1

# Seconds after the end of a block until every report of it has come, however late: five of the slowest's periods.
SETTLE_S = 0.5

# Seconds that a block may take longer than planned.
MAX_DELAY_S = 20.0

CONNECT_TIMEOUT_S = 10.0

# Seconds for the first reports of what is executed; the slowest comes ten times a second.
REPORT_TIMEOUT_S = 5.0
SEGMENT_MESSAGES = {messages.BY_NAME[name].ID for name in ("SegmentStart", "SegmentTravel", "SegmentHeading")}

FirmwareTime = Callable[[], float]
"""The firmware's true time in seconds at the session's present; known on simulated rigs."""


@dataclass
class BenchResult:
    """Figures of one bench; times in seconds."""

    segments_sent: int = 0
    segments_executed: int = 0
    segments_lost: int = 0
    segments_repeated: int = 0
    transmissions: int = 0
    segment_bytes: float = 0.0
    duration: float = 0.0
    disturbed_frames: int = 0
    round_trips: list[float] = field(default_factory=list)
    clock_errors: list[float] = field(default_factory=list)
    link: dict[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, with units in the names."""
        sent = max(self.segments_sent, 1)
        return {
            "segments_sent": self.segments_sent,
            "segments_executed": self.segments_executed,
            "segments_lost": self.segments_lost,
            "segments_repeated": self.segments_repeated,
            "transmissions": self.transmissions,
            "bytes_per_segment": round(self.segment_bytes / max(self.transmissions, 1), 2),
            "bytes_per_segment_with_retransmissions": round(self.segment_bytes / sent, 2),
            "round_trip_ms": _spread(self.round_trips, 1e3),
            "clock_error_us": _spread(self.clock_errors, 1e6) if self.clock_errors else None,
            "duration_s": round(self.duration, 3),
            "frames_dropped_on_purpose": self.disturbed_frames,
            "link": self.link,
        }


class Bench:
    """One bench over one open port. Raises PreflightFailed, SafetyStop (the firmware stopped), LinkLost."""

    def __init__(
        self,
        transport: FrameTransport,
        clock: Clock,
        disturbance: Disturbance,
        seed: int,
        firmware_time: FirmwareTime | None = None,
    ) -> None:
        self._wire: DisturbedFrames = disturb(transport, disturbance, clock.now, seed)
        self._clock = clock
        self._rng = np.random.default_rng([seed, 1])
        self._firmware_time = firmware_time
        self._link = Link(self._wire, clock, session=seed & 0xFFFF, tap=self._tap)
        self._executed = Executed()
        self.result = BenchResult()

    def run(self, seconds: float, on_progress: Callable[[float], None] | None = None) -> BenchResult:
        """Connects, arms, keeps the rover turning to and fro for about `seconds`, and disarms."""
        link, result = self._link, self.result
        link.connect(CONNECT_TIMEOUT_S)
        link.arm(CONNECT_TIMEOUT_S)
        self._run_for(SETTLE_S)
        self._executed.begin()
        begin = self._clock.now()
        while (elapsed := self._clock.now() - begin) < seconds:
            if on_progress is not None:
                on_progress(elapsed)
            self._block(turns(TURNS_IN_A_BLOCK, self._rng))
        result.duration = self._clock.now() - begin
        result.segments_sent = link.stream.sent
        result.segments_executed = self._executed.count(link.stream.sent)
        result.segments_lost = max(result.segments_lost, link.stream.sent - result.segments_executed)
        result.transmissions = link.stream.sent + link.stream.repeated
        result.round_trips = link.round_trips
        result.disturbed_frames = self._wire.dropped
        result.link = link.figures().as_dict()
        link.disarm()
        return result

    def close(self) -> None:
        """Lets the port go."""
        self._link.close()

    def _block(self, block: list[Turn]) -> None:
        before = self._reference()
        end = self._clock.now() + LEAD_S - PAUSE_S
        for turn in block:
            end = self._link.stream.begin(turn, end + PAUSE_S)
        deadline = end + MAX_DELAY_S
        while not (self._link.stream.all_done and self._clock.now() > end):
            self._cycle()
            if self._clock.now() > deadline:
                break  # what has not been executed by now shows in the comparison
        self._run_for(SETTLE_S)
        lost, repeated = compare(block, self._reference() - before)
        self.result.segments_lost += lost
        self.result.segments_repeated += repeated

    def _reference(self) -> float:
        assert self._executed.reference is not None
        return self._executed.reference.heading

    def _run_for(self, seconds: float) -> None:
        end = self._clock.now() + seconds
        while self._clock.now() < end or self._executed.reference is None or self._executed.status is None:
            if self._clock.now() > end + REPORT_TIMEOUT_S:
                missing = "which motion it executes" if self._executed.status is None else "how far it has turned"
                raise LinkLost(f"the firmware answers, but has not told {missing} for {REPORT_TIMEOUT_S:g} s")
            self._cycle()

    def _cycle(self) -> None:
        for event in self._events():
            self._executed.take(event)
        state = self._link.state
        if state is not None and state.state not in DRIVEABLE:
            raise SafetyStop(f"the firmware stopped in the middle of the bench: {state.state}, cause {state.cause}")
        if self._firmware_time is not None:
            told = self._link.clock_estimate.to_firmware(self._clock.now()) * 1e-6
            self.result.clock_errors.append(abs(told - self._firmware_time()))
        self._clock.advance(self._clock.now() + STEP_S)

    def _events(self) -> Iterator[Telemetry]:
        yield from self._link.poll()

    def _tap(self, direction: str, time: float, identifier: int, payload: bytes) -> None:
        if direction == "tx" and identifier in SEGMENT_MESSAGES:
            self.result.segment_bytes += self._wire.wire_bytes(len(payload))


def _spread(values: list[float], scale: float) -> dict[str, float]:
    return {
        "median": round(percentile(values, 0.5) * scale, 3),
        "p99": round(percentile(values, 0.99) * scale, 3),
    }
