"""Two profiles, travel and heading, as one sequence of segments with the breakpoints of both, quantised."""

from __future__ import annotations

import itertools
from dataclasses import replace

from rover.motion.profile import Profile
from rover.motion.segment import MAX_DURATION_US, MAX_JERK, MIN_DURATION_US, Segment

# One axis: begin and end in µs, jerk between them.
Pieces = list[tuple[int, int, float]]


def merge(travel: Profile | None, heading: Profile | None, *, until: float | None = None) -> list[Segment]:
    """Segments for both axes together; an axis whose profile is over, or None, has no jerk.

    Where breakpoints lie nearer together than the shortest segment (1 ms), a segment of 1 ms holds them all and has
    their mean jerk: exact in acceleration, within 1 µm/s in speed. `until` cuts the motion off after that many
    seconds. Empty when nothing moves.
    """
    profiles = [_snapped(profile.pieces) if profile else [] for profile in (travel, heading)]
    breaks = _breaks([end for pieces in profiles for _, end, _ in pieces], until)
    return [
        Segment(end - begin, _mean_jerk(profiles[0], begin, end), _mean_jerk(profiles[1], begin, end))
        for begin, end in itertools.pairwise(breaks)
    ]


def run(segments: list[Segment]) -> list[Segment]:
    """The segments as a whole run: from rest to rest."""
    if not segments:
        return []
    segments = [replace(segments[0], begin=True), *segments[1:]]
    return [*segments[:-1], replace(segments[-1], rest=True)]


def whole_microseconds(profile: Profile) -> list[tuple[int, int]]:
    """One axis alone: (duration in µs, jerk in millionths of the SI unit), each long enough for a segment.

    A piece that is too short takes from the next, or from the last before it, what makes it 1 ms, with their mean jerk.
    """
    found: list[tuple[int, int]] = []
    waiting, impulse = 0, 0.0
    for begin, end, jerk in _snapped(profile.pieces):
        length = end - begin
        if waiting:
            taken = min(MIN_DURATION_US - waiting, length)
            waiting += taken
            impulse += jerk * taken
            length -= taken
            if waiting < MIN_DURATION_US:
                continue
            found.append((waiting, round(impulse / waiting * 1e6)))
            waiting, impulse = 0, 0.0
        if length >= MIN_DURATION_US:
            found.append((length, round(jerk * 1e6)))
        elif length > 0:
            waiting, impulse = length, jerk * length
    if not waiting:
        return found
    if not found:
        return [(MIN_DURATION_US, round(impulse / MIN_DURATION_US * 1e6))]
    length, last = found.pop()
    missing = MIN_DURATION_US - waiting
    if length - missing < MIN_DURATION_US:
        return [*found, (length + waiting, round((last * length + impulse * 1e6) / (length + waiting)))]
    return [
        *found,
        (length - missing, last),
        (MIN_DURATION_US, round((impulse * 1e6 + last * missing) / MIN_DURATION_US)),
    ]


def _snapped(pieces: tuple[tuple[float, float], ...]) -> Pieces:
    """The profile on whole microseconds.

    What a boundary moves by is made up in the jerk beside it, so that the acceleration at the boundaries is the
    profile's own: left alone the difference would add up over a long cruise.
    """
    snapped: Pieces = []
    t = owed = 0.0
    begin = 0
    for duration, jerk in pieces:
        t += duration
        owed += jerk * duration
        end = round(t * 1e6)
        if end > begin:
            snapped.append((begin, end, owed / ((end - begin) * 1e-6)))
            begin, owed = end, 0.0
    return snapped


def _breaks(times: list[int], until: float | None) -> list[int]:
    """Boundaries in µs from 0 to the end, spaced as segments may be."""
    if not times:
        return [0]
    end = max(*times, MIN_DURATION_US)
    if until is not None:
        end = min(end, max(round(until * 1e6), MIN_DURATION_US))
    breaks = [0]
    for time in sorted(times):
        if time > breaks[-1]:
            at = min(max(time, breaks[-1] + MIN_DURATION_US), end - MIN_DURATION_US)
            if at - breaks[-1] >= MIN_DURATION_US and time < end:
                breaks.append(at)
    breaks.append(end)
    whole = [0]
    for time in breaks[1:]:
        while time - whole[-1] > MAX_DURATION_US:
            whole.append(whole[-1] + MAX_DURATION_US // 2)
        whole.append(time)
    return whole


def _mean_jerk(pieces: Pieces, begin: int, end: int) -> int:
    """Mean jerk between two times in µs, in millionths of the SI unit."""
    total = sum(jerk * max(0, min(until, end) - max(since, begin)) for since, until, jerk in pieces)
    return max(-MAX_JERK, min(MAX_JERK, round(total / (end - begin) * 1e6)))
