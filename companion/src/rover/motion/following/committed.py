"""The motion that has been sent and can't be taken back: where it ends, and what of it is still to come."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from rover.geometry import Pose2
from rover.motion.segment import Segment, State, advance, after

# How finely the pose is integrated where heading and travel change together; the error is below 1 µm.
INTEGRATION_STEP_S = 0.01
KEEP_S = 2.0


class CommittedMotion:
    """Segments with their start times on one clock (seconds), the newest last. Before the first, at rest."""

    def __init__(self) -> None:
        self._pieces: list[tuple[float, State, Segment]] = []
        self._end_time = -math.inf
        self._end_state = State()

    @property
    def end_time(self) -> float:
        """When the last segment ends; minus infinity before the first."""
        return self._end_time

    @property
    def end_state(self) -> State:
        """The state at the end of the last segment."""
        return self._end_state

    def append(self, segments: Sequence[Segment], start_time: float | None = None) -> None:
        """Adds segments. A begin segment starts at `start_time`, not before the end so far; others follow on.

        Raises ValueError when a begin segment has no such time.
        """
        for segment in segments:
            if segment.begin:
                if start_time is None or start_time < self._end_time - 1e-9:
                    raise ValueError("a begin segment needs a start time after the end of the run before")
                self._end_time = start_time
                self._end_state = self._end_state.rested()
            self._pieces.append((self._end_time, self._end_state, segment))
            self._end_state = after(self._end_state, segment)
            self._end_time += segment.duration_us * 1e-6

    def truncate(self, time: float, state: State | None = None) -> None:
        """The firmware has dropped everything from `time` on and stands still: forget it."""
        state = state or self.state_at(time)
        self._pieces = [piece for piece in self._pieces if piece[0] < time]
        self._end_time = time
        self._end_state = state.rested()

    def forget_before(self, now: float) -> None:
        """Drops what ended long ago."""
        while self._pieces:
            begin, _, segment = self._pieces[0]
            if begin + segment.duration_us * 1e-6 >= now - KEEP_S:
                return
            self._pieces.pop(0)

    def state_at(self, time: float) -> State:
        """The commanded state at a time; between runs and after the end it rests."""
        state = self._pieces[0][1] if self._pieces else self._end_state
        for begin, at_begin, segment in self._pieces:
            if time < begin:
                return state
            t = time - begin
            if t < segment.duration_us * 1e-6:
                return advance(at_begin, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            state = after(at_begin, segment)
        return state

    def increments(self, begin: float, end: float) -> list[tuple[float, float]]:
        """(travel, heading) steps commanded between two times, in order."""
        if not end > begin or not self._pieces:
            return []
        begin = max(begin, self._pieces[0][0])
        count = max(1, math.ceil((end - begin) / INTEGRATION_STEP_S))
        if end <= begin:
            return []
        states = self._sample(begin, (end - begin) / count, count + 1)
        return [(b.travel - a.travel, b.heading - a.heading) for a, b in itertools.pairwise(states)]

    def _sample(self, begin: float, step: float, count: int) -> list[State]:
        states: list[State] = []
        index = 0
        pieces = self._pieces
        for number in range(count):
            time = begin + number * step
            while index + 1 < len(pieces) and pieces[index + 1][0] <= time:
                index += 1
            at, state, segment = pieces[index]
            t = time - at
            if t >= segment.duration_us * 1e-6:
                states.append(after(state, segment))
            else:
                states.append(advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, max(t, 0.0)))
        return states


def dead_reckon(
    pose: Pose2,
    increments: Sequence[tuple[float, float]],
    *,
    scale: float = 1.0,
    drift: float = 0.0,
    turn_scale: float = 1.0,
) -> Pose2:
    """`pose` moved by (travel, heading) increments.

    `scale`: metres of ground per metre; `turn_scale`: radians per radian; `drift`: radians per metre of travel.
    """
    x, y, heading = pose.x, pose.y, pose.heading
    for travel, turn in increments:
        turn = turn_scale * turn + drift * travel
        middle = heading + 0.5 * turn
        x += scale * travel * math.cos(middle)
        y += scale * travel * math.sin(middle)
        heading += turn
    return Pose2(x, y, heading)
