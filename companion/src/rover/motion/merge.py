"""Two profiles, travel and heading, as one sequence of segments with the breakpoints of both, quantised."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from rover.motion.profile import Profile
from rover.motion.segment import DURATION_MAX_US, DURATION_MIN_US, JERK_MAX, Segment

Pieces = tuple[tuple[float, float], ...]

# Errors of the end below this (SI) are what quantisation leaves anyway.
NEGLIGIBLE = 1e-5


def merge(travel: Profile | None, heading: Profile | None, *, until: float | None = None) -> list[Segment]:
    """Segments for both axes together; an axis whose profile is over, or None, has no jerk.

    Breakpoints nearer together than the shortest segment (1 ms) become one. A segment that then spans several pieces
    has their mean jerk, and all jerks of that axis are corrected by the least amount that makes its end exact
    again. `until` cuts the motion off after that many seconds. Empty when nothing moves.
    """
    profiles = [profile.pieces if profile else () for profile in (travel, heading)]
    breaks = _breaks([time for pieces in profiles for time in _times(pieces)], until)
    spans = list(itertools.pairwise(breaks))
    jerks = [_quantised(pieces, spans) for pieces in profiles]
    return [
        Segment(end - begin, along, around)
        for (begin, end), along, around in zip(spans, jerks[0], jerks[1], strict=True)
    ]


def run(segments: list[Segment]) -> list[Segment]:
    """The segments as a whole run: from rest to rest."""
    if not segments:
        return []
    segments = [replace(segments[0], begin=True), *segments[1:]]
    return [*segments[:-1], replace(segments[-1], rest=True)]


def _times(pieces: Pieces) -> list[float]:
    times = []
    t = 0.0
    for duration, _ in pieces:
        t += duration
        times.append(t)
    return times


def _breaks(times: list[float], until: float | None) -> list[int]:
    """Boundaries in µs from 0 to the end, none nearer together than a segment may be short or long."""
    if not times:
        return [0]
    end = max(round(max(times) * 1e6), DURATION_MIN_US)
    if until is not None:
        end = min(end, max(round(until * 1e6), DURATION_MIN_US))
    breaks = [0]
    for time in sorted(round(t * 1e6) for t in times):
        if breaks[-1] + DURATION_MIN_US <= time <= end - DURATION_MIN_US:
            breaks.append(time)
    breaks.append(end)
    whole = [0]
    for time in breaks[1:]:
        while time - whole[-1] > DURATION_MAX_US:
            whole.append(whole[-1] + DURATION_MAX_US // 2)
        whole.append(time)
    return whole


def _quantised(pieces: Pieces, spans: list[tuple[int, int]]) -> list[int]:
    """The jerk of one axis in each span (µs), in millionths of the SI unit."""
    if not pieces:
        return [0] * len(spans)
    jerks = np.array([_mean_jerk(pieces, begin * 1e-6, end * 1e-6) for begin, end in spans])
    lengths = np.array([(end - begin) * 1e-6 for begin, end in spans])
    left = spans[-1][1] * 1e-6 - np.cumsum(lengths)  # from the end of each span to the end of all
    # Position, speed and acceleration at the end are linear in the jerks.
    effect = np.stack(
        [
            lengths * (lengths**2 / 6.0 + lengths * left / 2.0 + left**2 / 2.0),
            lengths * (lengths / 2.0 + left),
            lengths,
        ]
    )
    error = np.array(_end_of(pieces, spans[-1][1] * 1e-6)) - effect @ jerks
    if np.abs(error).max() > NEGLIGIBLE and len(spans) >= 3:
        jerks = jerks + np.linalg.lstsq(effect, error, rcond=None)[0]
    return [max(-JERK_MAX, min(JERK_MAX, round(jerk * 1e6))) for jerk in jerks.tolist()]


def _end_of(pieces: Pieces, until: float) -> tuple[float, float, float]:
    """What the jerks alone add to position, speed and acceleration up to a time."""
    position = speed = acceleration = t = 0.0
    for duration, jerk in (*pieces, (until, 0.0)):
        step = min(duration, until - t)
        if step <= 0.0:
            break
        position += step * (speed + step * (acceleration / 2.0 + step * jerk / 6.0))
        speed += step * (acceleration + step * jerk / 2.0)
        acceleration += step * jerk
        t += step
    return position, speed, acceleration


def _mean_jerk(pieces: Pieces, begin: float, end: float) -> float:
    """Mean jerk between two times."""
    total = 0.0
    t = 0.0
    for duration, jerk in pieces:
        overlap = min(t + duration, end) - max(t, begin)
        if overlap > 0.0:
            total += jerk * overlap
        t += duration
    return total / (end - begin)
