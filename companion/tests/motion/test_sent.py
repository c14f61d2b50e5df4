"""What is about to be sent is held to the vehicle's limits, whatever planned it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rover.motion.following.sent import broken
from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import Segment, State, advance, after
from rover.vehicle import STANDARD

LIMITS = DrivingLimits.of(STANDARD)
JERK = round(STANDARD.travel.jerk * 1e6)


def test_a_gentle_start_and_stop_is_sent() -> None:
    up, down = Segment(100_000, JERK, 0, begin=True), Segment(100_000, -JERK, 0)
    assert broken(State(), [up, down, down, up], LIMITS) == ""


@pytest.mark.parametrize(
    ("segments", "named"),
    [
        ([Segment(50_000, 2 * JERK, 0, begin=True)], "jerk"),
        ([Segment(250_000, JERK, 0, begin=True)], "acceleration"),
        ([Segment(160_000, JERK, 0, begin=True), Segment(600_000, 0, 0), Segment(160_000, -JERK, 0)], "speed"),
        ([Segment(100_000, 0, 8_300_000, begin=True)], "turn jerk"),
    ],
)
def test_what_exceeds_a_limit_is_named(segments: list[Segment], named: str) -> None:
    assert broken(State(), segments, LIMITS).startswith(named)


def test_too_fast_round_a_bend_is_found_though_speed_and_turn_rate_are_allowed() -> None:
    state = State(speed=0.24, turn_rate=1.15)
    assert broken(state, [Segment(100_000, 0, 0)], LIMITS).startswith("lateral acceleration")


jerks = st.integers(-2 * JERK, 2 * JERK)


@given(st.lists(st.tuples(st.integers(1_000, 300_000), jerks, jerks), min_size=1, max_size=6))
def test_nothing_passes_that_a_fine_look_at_every_moment_finds_too_fast(rows: list[tuple[int, int, int]]) -> None:
    segments = [Segment(*row) for row in rows]
    state, fastest = State(), np.zeros(4)
    for segment in segments:
        for time in np.linspace(0.0, segment.duration_us * 1e-6, 200).tolist():
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, time)
            fastest = np.maximum(fastest, np.abs((at.speed, at.acceleration, at.turn_rate, at.turn_acceleration)))
        state = after(state, segment)
    travel, heading = STANDARD.travel, STANDARD.heading
    allowed = np.array((travel.speed, travel.acceleration, heading.speed, heading.acceleration))
    if not broken(State(), segments, LIMITS):
        assert (fastest <= allowed * 1.003).all()
