"""Driving one stretch: the follower's segments, and whether the way ahead is still free.

Keeps the committed motion in step with what the firmware runs: a stop by the firmware truncates it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mission.freespace import FreeSpace
from rover.motion.following.committed import CommittedMotion
from rover.motion.following.follower import PathFollower, SpeedLimit
from rover.motion.following.sent import broken
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import Segment
from rover.vehicle import Limits, Vehicle

# A run starts this long after it is decided on: a loop of 20 ms, the wire, and room for one repetition.
START_LEAD = 0.16


# How far the rover may still go after a stop that starts at the end of what is committed, metres: 0.7 s of driving and
# the braking itself.
COMMITTED_REACH = 0.30


AT_HOME = Pose2(0.0, 0.0, 0.0)

# Share of the speed that is left to a rover that something makes careful.
SLOW = 0.5

NOT_FREE = "the way ahead is no longer free"

# Legs of a path nearer to each other than this can't be told apart by the pose, metres.
SAME_PLACE = 0.03


class Drive:
    """One rover's motion. All times are the companion's, seconds."""

    def __init__(self, vehicle: Vehicle, cruise_speed: float, speed_limit: SpeedLimit | None = None) -> None:
        """speed_limit: of places in map, m/s, beside `cruise_speed`."""
        travel = Limits(cruise_speed, vehicle.travel.acceleration, vehicle.travel.jerk)
        self.committed = CommittedMotion()
        self._travel = travel
        self._limit_of_places = speed_limit
        self._slowed_by: set[str] = set()
        self._follower = PathFollower(vehicle, travel, speed_limit=speed_limit)
        self._path: NDArray[np.float64] = np.empty((0, 2))
        self._allowed = DrivingLimits.of(vehicle)
        self.blocked = False
        # What has blocked it.
        self.why = NOT_FREE
        self._escape_left = 0.0
        self._last: tuple[float, float] | None = None
        # Where the map of when the path was planned lies in the map of now: the path moves with its ground.
        self._moved = AT_HOME

    @property
    def path(self) -> NDArray[np.float64]:
        """The polyline (N, 2) that is being driven, in map, its corners round where they are driven round."""
        return self._moved.transform(self._path)

    def move(self, shift: Pose2) -> None:
        """The ground of the path has moved in map by `shift`, and the rover with it: nothing jumps for the wheels."""
        self._moved = shift.compose(self._moved)

    @property
    def restarts(self) -> int:
        """How often the follower had to stop and aim anew."""
        return self._follower.restarts

    def start(
        self,
        path: NDArray[np.float64],
        final_heading: float | None,
        escape: float = 0.0,
        space: FreeSpace | None = None,
    ) -> None:
        """Takes a new path; the rover must be at rest. `space`: the map that says where corners may be rounded; without
        it all but soft corners are turned on the spot.

        `escape`: metres at its beginning over which it leads out of ground that has become blocked around the rover.
        """
        self._follower.speed_limit = self._speed_limit()
        self._escape_left = escape
        self._moved = AT_HOME
        self._last = None
        self.blocked = False
        clearance = ClearanceMap.of(space.field(), space.radius) if space is not None else None
        self._follower.follow([(float(x), float(y)) for x, y in path], final_heading, clearance)
        # What is checked while driving is what is driven.
        self._path = np.array(self._follower.path) if clearance is not None and self._follower.path else path

    def slow(self, why: str, wanted: bool) -> None:
        """Brakes; what is driven from then on is driven at SLOW of the speed while anything wants it."""
        before = bool(self._slowed_by)
        (self._slowed_by.add if wanted else self._slowed_by.discard)(why)
        if bool(self._slowed_by) != before:
            self.stop()

    @property
    def cruise_speed(self) -> float:
        """Of what is driven next, m/s."""
        return self._travel.speed * (SLOW if self._slowed_by else 1.0)

    def _speed_limit(self) -> SpeedLimit | None:
        """That of places and that of a careful rover, the lower one."""
        cruise, places = self.cruise_speed, self._limit_of_places
        if not self._slowed_by or places is None:
            return cruise if self._slowed_by else places
        if callable(places):
            return lambda x, y: min(cruise, places(x, y))
        return min(cruise, places)

    def commanded(self, since: float, until: float) -> float:
        """Metres that the wheels were to roll between two times, the faster one."""
        steps = self.committed.increments(since, until)
        return sum(max(abs(travel), 0.5 * self._follower.vehicle.track_width * abs(turn)) for travel, turn in steps)

    def turn(self, pose: Pose2, heading: float) -> None:
        """Turns where it stands."""
        self.start(np.array([[pose.x, pose.y]]), heading)

    def back_off(self, distance: float, speed: float) -> None:
        """Straight back, metres and m/s, over the ground that the rover has come by."""
        self._path, self.blocked = np.empty((0, 2)), False
        self._follower.back_off(distance, speed)

    def stop(self) -> None:
        """Brakes within the limits from the end of what is committed."""
        self._follower.request_stop()

    def halted(self, now: float) -> None:
        """The firmware has stopped by itself and thrown its queue away."""
        self.committed.truncate(now)
        self._follower.request_stop()
        self._follower.next_segments(now, Pose2(0.0, 0.0, 0.0), self.committed)

    def check(self, space: FreeSpace, pose: Pose2, forbidden: FreeSpace | None = None) -> bool:
        """Brakes when the rest of the path is no longer free; True when that would be too late.

        What is committed can't be taken back: where it leads into blocked ground only the firmware stops in time.
        `forbidden`: ground that is worth such a stop, where `space` is kept off more than that.
        """
        if self.blocked or len(self._path) < 2:
            return False
        if self._last is not None:
            self._escape_left -= math.hypot(pose.x - self._last[0], pose.y - self._last[1])
        self._last = (pose.x, pose.y)
        ahead = skip(remaining(self.path, pose), max(self._escape_left, 0.0))
        if space.is_clear(ahead):
            return False
        self.blocked, self.why = True, NOT_FREE
        self.stop()
        return not (forbidden or space).is_clear(cut(ahead, COMMITTED_REACH))

    def step(self, now: float, pose: Pose2) -> tuple[list[Segment], float | None]:
        """Segments to send now, and when a run that begins with them starts."""
        inside = pose if self._moved == AT_HOME else pose.relative_to(self._moved)
        segments = self._follower.next_segments(now, inside, self.committed)
        wrong = broken(self.committed.end_state, segments, self._allowed)
        if wrong:
            self.blocked, self.why = True, f"motion was not sent, its {wrong}"
            self.stop()
            segments = self._follower.next_segments(now, inside, self.committed)
        if not segments:
            return [], None
        start = max(now + START_LEAD, self.committed.end_time) if segments[0].begin else None
        self.committed.append(segments, start)
        return segments, start

    def at_rest(self, now: float) -> bool:
        """True when the path is done and everything committed has run."""
        return self._follower.done and now >= self.committed.end_time


def remaining(path: NDArray[np.float64], pose: Pose2) -> NDArray[np.float64]:
    """The part of a polyline (N, 2) that still lies ahead, from the point nearest to the rover on."""
    start, end = path[:-1], path[1:]
    along = end - start
    squared = np.maximum((along**2).sum(axis=1), 1e-12)
    here = np.array([pose.x, pose.y])
    t = np.clip(((here - start) * along).sum(axis=1) / squared, 0.0, 1.0)
    nearest = start + t[:, None] * along
    distance = np.linalg.norm(nearest - here, axis=1)
    # Where a path doubles back the earlier leg counts: checking what is driven already costs nothing.
    leg = int(np.argmax(distance <= distance.min() + SAME_PLACE))
    return np.vstack([nearest[leg], path[leg + 1 :]])


def skip(path: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """A polyline (N, 2) without its first `length` metres; its last point at the least."""
    return cut(path[::-1], max(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) - length, 0.0))[::-1]


def cut(path: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """The first `length` metres of a polyline (N, 2)."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if length >= way[-1]:
        return path
    if length <= 0.0:
        return path[:1]
    last = int(np.searchsorted(way, length, side="right"))
    share = (length - way[last - 1]) / steps[last - 1]
    return np.vstack([path[:last], path[last - 1] + share * (path[last] - path[last - 1])])
