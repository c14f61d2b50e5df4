"""Constant-jerk segments as they go over the wire (SegmentTravel and SegmentHeading of rover.dbc), and what they do.

Every value is the quantised integer that is sent, so the companion and the firmware compute the same motion.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

MIN_DURATION_US = 1_000
MAX_DURATION_US = 0xFFFFFF
# µm/s³ and µrad/s³.
MAX_JERK = 0x7FFFFF

FLAG_BEGIN = 1
FLAG_REST = 2


@dataclass(frozen=True)
class Segment:
    """Constant jerk of travel (µm/s³) and heading (µrad/s³) for a duration in µs.

    `begin`: the first of a run, from rest. `rest`: speeds and accelerations are exactly zero at its end.
    Raises BadInput when a value does not fit the wire.
    """

    duration_us: int
    jerk_travel: int
    jerk_heading: int
    begin: bool = False
    rest: bool = False

    def __post_init__(self) -> None:
        if (
            MIN_DURATION_US <= self.duration_us <= MAX_DURATION_US
            and -MAX_JERK - 1 <= self.jerk_travel <= MAX_JERK
            and -MAX_JERK - 1 <= self.jerk_heading <= MAX_JERK
        ):
            return
        if not MIN_DURATION_US <= self.duration_us <= MAX_DURATION_US:
            raise BadInput(f"a segment lasts {MIN_DURATION_US} to {MAX_DURATION_US} µs, not {self.duration_us}")
        for name, jerk in (("travel", self.jerk_travel), ("heading", self.jerk_heading)):
            if not -MAX_JERK - 1 <= jerk <= MAX_JERK:
                raise BadInput(f"jerk of {name} must fit 24 bits, not {jerk}")

    @classmethod
    def rows(cls, rows: NDArray[np.int64]) -> list[Segment]:
        """Many at once from (N, 5), the fields in order; the same as making each by itself, in half the time."""
        durations, jerks = rows[:, 0], rows[:, 1:3]
        fits = len(rows) == 0 or (
            durations.min() >= MIN_DURATION_US
            and durations.max() <= MAX_DURATION_US
            and jerks.min() >= -MAX_JERK - 1
            and jerks.max() <= MAX_JERK
        )
        found = []
        for duration_us, jerk_travel, jerk_heading, begin, rest in rows.tolist():
            if not fits:
                cls(duration_us, jerk_travel, jerk_heading)  # raises at the first that does not fit
            segment = object.__new__(cls)
            fields = segment.__dict__
            fields["duration_us"] = duration_us
            fields["jerk_travel"] = jerk_travel
            fields["jerk_heading"] = jerk_heading
            fields["begin"] = begin > 0
            fields["rest"] = rest > 0
            found.append(segment)
        return found

    @property
    def flags(self) -> int:
        """The flags byte of SegmentHeading."""
        return FLAG_BEGIN * self.begin | FLAG_REST * self.rest

    @classmethod
    def from_wire(cls, duration: int, jerk_travel: int, jerk_heading: int, flags: int) -> Segment:
        """From the raw fields of both messages."""
        return cls(duration, jerk_travel, jerk_heading, bool(flags & FLAG_BEGIN), bool(flags & FLAG_REST))


@dataclass(frozen=True)
class State:
    """Motion along both axes: metres and radians since the start, with their first two derivatives (SI)."""

    travel: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    heading: float = 0.0
    turn_rate: float = 0.0
    turn_acceleration: float = 0.0

    @property
    def at_rest(self) -> bool:
        """True when nothing moves."""
        return not (self.speed or self.acceleration or self.turn_rate or self.turn_acceleration)

    def rested(self) -> State:
        """The same place, at rest."""
        return State(travel=self.travel, heading=self.heading)


def advance(state: State, jerk_travel: float, jerk_heading: float, t: float) -> State:
    """The state `t` seconds on under constant jerks (SI)."""
    return State(
        state.travel + t * (state.speed + t * (state.acceleration / 2.0 + t * jerk_travel / 6.0)),
        state.speed + t * (state.acceleration + t * jerk_travel / 2.0),
        state.acceleration + t * jerk_travel,
        state.heading + t * (state.turn_rate + t * (state.turn_acceleration / 2.0 + t * jerk_heading / 6.0)),
        state.turn_rate + t * (state.turn_acceleration + t * jerk_heading / 2.0),
        state.turn_acceleration + t * jerk_heading,
    )


def after(state: State, segment: Segment) -> State:
    """The state at the end of a segment that starts in `state`."""
    end = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, segment.duration_us * 1e-6)
    return end.rested() if segment.rest else end


def end_state(segments: Iterable[Segment], state: State) -> State:
    """The state after all segments."""
    for segment in segments:
        state = after(state, segment)
    return state


def evaluate(segments: Iterable[Segment], state: State, t: float) -> State:
    """The state `t` seconds after the first segment began in `state`; after the last it stays as it ends (at rest)."""
    left = t
    for segment in segments:
        duration = segment.duration_us * 1e-6
        if left < duration:
            return advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, max(left, 0.0))
        state = after(state, segment)
        left -= duration
    return state


def duration_us(segments: Iterable[Segment]) -> int:
    """How long the segments last together."""
    return sum(segment.duration_us for segment in segments)


def split(segments: Sequence[Segment], most_us: int) -> list[Segment]:
    """The same motion in pieces of at most about `most_us` (never shorter than a segment may be)."""
    pieces: list[Segment] = []
    for segment in segments:
        count = max(1, -(-segment.duration_us // most_us))
        count = min(count, max(1, segment.duration_us // MIN_DURATION_US))
        done = 0
        for number in range(count):
            until = segment.duration_us * (number + 1) // count
            pieces.append(
                replace(
                    segment,
                    duration_us=until - done,
                    begin=segment.begin and number == 0,
                    rest=segment.rest and number == count - 1,
                )
            )
            done = until
    return pieces
