"""Segments: what fits the wire, and exact evaluation of the quantised values."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.motion import Segment, State, evaluate
from rover.motion.segment import MAX_JERK, duration_us, end_state, split

SEGMENTS = st.builds(
    Segment,
    st.integers(1_000, 2_000_000),
    st.integers(-MAX_JERK - 1, MAX_JERK),
    st.integers(-MAX_JERK - 1, MAX_JERK),
)


@given(SEGMENTS, st.booleans(), st.booleans())
def test_the_wire_fields_give_the_segment_back(segment, begin, rest):
    flagged = Segment(segment.duration_us, segment.jerk_travel, segment.jerk_heading, begin, rest)
    again = Segment.from_wire(flagged.duration_us, flagged.jerk_travel, flagged.jerk_heading, flagged.flags)
    assert again == flagged


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((999, 0, 0), "lasts 1000 to"),
        ((1 << 24, 0, 0), "lasts 1000 to"),
        ((1000, MAX_JERK + 1, 0), "jerk of travel"),
        ((1000, 0, -MAX_JERK - 2), "jerk of heading"),
    ],
)
def test_values_that_do_not_fit_the_wire_are_refused(values, message):
    with pytest.raises(BadInput, match=message):
        Segment(*values)


@given(st.lists(SEGMENTS, min_size=1, max_size=6), st.floats(0.0, 1.0))
@settings(max_examples=60)
def test_evaluation_is_exact_for_the_quantised_values(segments, fraction):
    """Against rational arithmetic on the integers."""
    until = round(fraction * duration_us(segments))
    position, speed, acceleration = Fraction(0), Fraction(0), Fraction(0)
    left = until
    for segment in segments:
        t = Fraction(min(left, segment.duration_us), 10**6)
        jerk = Fraction(segment.jerk_travel, 10**6)
        position += speed * t + acceleration * t**2 / 2 + jerk * t**3 / 6
        speed += acceleration * t + jerk * t**2 / 2
        acceleration += jerk * t
        left -= min(left, segment.duration_us)
    state = evaluate(segments, State(), until * 1e-6)
    scale = 1e-9 * max(1.0, abs(float(position)), abs(float(speed)))
    assert state.travel == pytest.approx(float(position), abs=scale)
    assert state.speed == pytest.approx(float(speed), abs=scale)
    assert state.acceleration == pytest.approx(float(acceleration), abs=scale)


@given(st.lists(SEGMENTS, min_size=1, max_size=4), st.integers(1_000, 300_000))
@settings(max_examples=60)
def test_split_segments_are_the_same_motion(segments, most):
    segments = [*segments[:-1], Segment(segments[-1].duration_us, 0, 0, rest=True)]
    pieces = split(segments, most)
    assert duration_us(pieces) == duration_us(segments)
    assert max(piece.duration_us for piece in pieces) <= max(most, 2_000)
    assert [piece.rest for piece in pieces].count(True) == 1
    assert pieces[-1].rest
    a, b = end_state(segments, State()), end_state(pieces, State())
    assert b.travel == pytest.approx(a.travel, abs=1e-8 * max(1.0, abs(a.travel)))
    assert b.heading == pytest.approx(a.heading, abs=1e-8 * max(1.0, abs(a.heading)))


def test_rest_means_exactly_at_rest_and_evaluation_stays_there():
    segments = [Segment(100_000, 1_000_000, 0, begin=True), Segment(100_000, -1_000_001, 5, rest=True)]
    end = end_state(segments, State())
    assert end.at_rest
    assert evaluate(segments, State(), 10.0) == end
