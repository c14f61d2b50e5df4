"""Two profiles, travel and heading, as one sequence of segments with the breakpoints of both, quantised."""

from __future__ import annotations

from dataclasses import replace

from rover.motion.profile import Profile
from rover.motion.segment import DURATION_MAX_US, DURATION_MIN_US, JERK_MAX, Segment

Pieces = tuple[tuple[float, float], ...]


def merge(travel: Profile | None, heading: Profile | None, *, until: float | None = None) -> list[Segment]:
    """Segments for both axes together; an axis whose profile is over, or None, has no jerk.

    Breakpoints nearer together than the shortest segment (1 ms) become one; the jerk of a segment that then spans
    several pieces is their mean, which keeps the acceleration at its end exact. `until` cuts the motion off after that
    many seconds. Empty when nothing moves.
    """
    pieces_travel: Pieces = travel.pieces if travel else ()
    pieces_heading: Pieces = heading.pieces if heading else ()
    breaks = _breaks(_times(pieces_travel) + _times(pieces_heading), until)
    segments: list[Segment] = []
    for begin, end in zip(breaks[:-1], breaks[1:], strict=True):
        segments.append(
            Segment(end - begin, _mean_jerk(pieces_travel, begin, end), _mean_jerk(pieces_heading, begin, end))
        )
    return segments


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


def _mean_jerk(pieces: Pieces, begin_us: int, end_us: int) -> int:
    """Mean jerk between two times, in millionths of the SI unit."""
    begin, end = begin_us * 1e-6, end_us * 1e-6
    total = 0.0
    t = 0.0
    for duration, jerk in pieces:
        overlap = min(t + duration, end) - max(t, begin)
        if overlap > 0.0:
            total += jerk * overlap
        t += duration
    return max(-JERK_MAX, min(JERK_MAX, round(total / (end - begin) * 1e6)))
