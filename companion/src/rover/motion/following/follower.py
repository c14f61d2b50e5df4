"""Follows a path in closed loop: turns on the spot, drives stretches of lines and curves, and steers back to the path.

With a map the corners are rounded where it has room (blend.py): speed and turning along them are planned beforehand,
and only the rest is steered.

Only a few tenths of a second are committed ahead. Each new piece of motion starts from the state at the end of what is
committed and from the pose that the rover will have there: the estimate, moved by the motion still to come.
Pure of clock and randomness: the same calls give the same segments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle
from rover.motion.following.committed import CommittedMotion, dead_reckon
from rover.motion.following.curve import Curve, together
from rover.motion.following.settings import FollowerSettings
from rover.motion.following.slip import SlipEstimate
from rover.motion.merge import merge, run
from rover.motion.path.blend import blend_path
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.polyline import Polyline, stretches
from rover.motion.path.rounding import BlendSettings
from rover.motion.profile import Axis, MotionError, Profile, speed_after, to_position
from rover.motion.segment import Segment, State, split
from rover.motion.stop import stop_distance, stop_profile, stop_segments
from rover.vehicle import Limits, Vehicle

SpeedLimit = float | Callable[[float, float], float]


# Of the vehicle's limit of heading jerk, what steering may take while a curve takes the rest.
STEERING_SHARE = 0.65
# Radians: a larger error is no longer a matter of steering.
MAX_STEERING_RAD = 0.6


class PathFollower:
    """Turns poses into segments until the path is driven.

    `limits`: travel limits, the vehicle's own when None. `speed_limit`: metres per second, or a function of the
    position (x, y) in the map, for a speed that depends on the clearance.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        limits: Limits | None = None,
        *,
        settings: FollowerSettings | None = None,
        speed_limit: SpeedLimit | None = None,
    ) -> None:
        self.vehicle = vehicle
        self.limits = limits or vehicle.travel
        self.settings = settings or FollowerSettings()
        self.speed_limit = speed_limit
        self.slip = SlipEstimate()
        self.cross_track = 0.0  # metres to the left of the path, at the last look
        self.restarts = 0  # how often the rover had to stop and aim anew
        self._stretches: list[Polyline] = []
        self._final_heading: float | None = None
        self._pending: list[Segment] = []
        self._stage = "done"  # aim, drive, face; done, stopped, lost
        self._restarts_here = 0
        self._progress = 0.0
        self._target: float | None = None  # where the stretch ends, in commanded travel
        self._braking = False
        self._tries = 0
        self._stop_wanted = False
        self._turn: tuple[float, float] | None = None
        self._along: tuple[float, float] | None = None  # commanded travel and where on the curve that was
        bounds, steering = vehicle.heading, self.settings.steering
        self._steering = replace(steering, jerk=min(steering.jerk, STEERING_SHARE * bounds.jerk))
        self._curve_limits = replace(
            DrivingLimits.of(vehicle, self.limits.speed, self.settings.lateral),
            travel=self.limits,
            give=self.settings.give,
            min_speed=self.settings.min_curve_speed,
            heading=Limits(
                bounds.speed - self._steering.speed,
                bounds.acceleration - self._steering.acceleration,
                bounds.jerk - self._steering.jerk,
            ),
        )

    @property
    def path(self) -> list[tuple[float, float]]:
        """The points of what is still to be driven, its corners round where they are driven round."""
        return [point for stretch in self._stretches for point in stretch.points]

    @property
    def done(self) -> bool:
        """True when the path has been driven to its end, or a stop that ends it has been committed."""
        return self._stage in ("done", "stopped", "lost") and not self._pending

    @property
    def stopped(self) -> bool:
        """True when `request_stop` ended the path."""
        return self._stage == "stopped"

    @property
    def lost(self) -> bool:
        """True when the rover came too far off the path and stopped: a new path is due."""
        return self._stage == "lost"

    def follow(
        self, path: Sequence[Sequence[float]], final_heading: float | None = None, clearance: ClearanceMap | None = None
    ) -> None:
        """Takes a new path in the map, (N, 2), first point near the rover. Call it while at rest.

        With `clearance` corners are rounded where it has room; without, all but soft ones are turned on the spot.
        Raises BadInput when a coordinate is not finite.
        """
        points = [(float(x), float(y)) for x, y in path]
        if not all(math.isfinite(v) for point in points for v in point):
            raise BadInput("the path holds a coordinate that is not finite")
        self._stretches = self._cut(points, clearance)
        self._final_heading = final_heading
        self._pending = []
        self._stop_wanted = False
        self._turn = None
        self._restarts_here = 0
        self._enter("aim" if self._stretches else "face")

    def _cut(self, points: list[tuple[float, float]], clearance: ClearanceMap | None) -> list[Polyline]:
        settings = self.settings
        if not points:
            return []
        if clearance is None:
            return stretches(points, settings.soft_corner, settings.arrival)
        blend = BlendSettings(
            max_cut=settings.max_cut,
            min_leg=settings.arrival,
            slack=settings.tracking,
            kink=settings.soft_corner,
            widen=settings.widen,
        )
        found = blend_path(points, self._curve_limits, blend, clearance)
        return [Curve(stretch, self.limits) for stretch in found.stretches]

    def back_off(self, distance: float, speed: float) -> None:
        """Goes straight back by so many metres, at no more than this speed. Call it while at rest."""
        self.follow([])
        limits = replace(self.limits, speed=min(speed, self.limits.speed))
        profile = to_position(Axis(), -distance, limits)
        self._pending = split(run(merge(profile, None)), round(self.settings.chunk * 1e6))

    def request_stop(self) -> None:
        """The next call returns a jerk-limited stop from the end of what is committed."""
        self._stop_wanted = True

    def next_segments(self, now: float, pose: Pose2, committed: CommittedMotion) -> list[Segment]:
        """Segments to append to `committed`, often none. `pose`: the estimate at `now`, in the map.

        The first of a run has `begin` set; the caller chooses when it starts (not before now).
        """
        committed.forget_before(now)
        if not all(math.isfinite(v) for v in (pose.x, pose.y, pose.heading)):
            self._stop_wanted = not self.done  # blind: no motion can be planned from here
        if self._stop_wanted:
            return self._stop(committed)
        if not self._pending:
            try:
                self._plan(now, pose, committed)
            except MotionError:
                self._restart(committed)
        return self._emit(now, committed)

    def _emit(self, now: float, committed: CommittedMotion) -> list[Segment]:
        ahead = max(committed.end_time - now, 0.0)
        out: list[Segment] = []
        while self._pending and ahead < self.settings.horizon:
            segment = self._pending.pop(0)
            ahead += segment.duration_us * 1e-6
            out.append(segment)
        return out

    def _stop(self, committed: CommittedMotion) -> list[Segment]:
        self._stop_wanted = False
        self._pending = []
        self._stage = "stopped"
        if committed.end_state.at_rest:
            return []
        return stop_segments(committed.end_state, self.limits, self.vehicle.heading)

    def _restart(self, committed: CommittedMotion) -> None:
        """A controlled stop; the stretch is then aimed at anew, if that has not been tried too often."""
        self.restarts += 1
        self._restarts_here += 1
        self._pending = self._stop(committed)
        if self._restarts_here > self.settings.max_restarts:
            self._enter("lost")
        else:
            self._enter("aim" if self._stretches else "face")

    def _give_up(self, committed: CommittedMotion) -> None:
        self._pending = self._stop(committed)
        self._enter("lost")

    def _enter(self, stage: str) -> None:
        self._stage = stage
        self._tries = 0
        self._target = None
        self._braking = False
        self._along = None
        if stage == "aim":
            self._progress = 0.0
        self.slip.restart()

    def _plan(self, now: float, pose: Pose2, committed: CommittedMotion) -> None:
        if self._stage in ("done", "stopped", "lost"):
            return
        if self._stage == "drive":
            if committed.end_time - now < self.settings.horizon:
                self._drive(now, pose, committed)
            return
        if now < committed.end_time + self.settings.settle:
            return
        self._learn_turn(pose)
        if self._stage == "aim":
            self._aim(pose)
        if self._stage == "face":
            self._face(pose)
        if self._stage == "drive":
            self._drive(now, pose, committed)

    def _learn_turn(self, pose: Pose2) -> None:
        if self._turn is not None:
            commanded, before = self._turn
            observed = wrap_angle(pose.heading - before - commanded) + commanded
            self.slip.turned(commanded, observed)
            self._turn = None

    def _aim(self, pose: Pose2) -> None:
        """Turns towards the path ahead; small errors are left to the steering."""
        while self._stretches:
            path = self._stretches[0]
            s, self.cross_track = path.project(pose.x, pose.y, 0.0, path.length)
            x, y = path.at(path.length)
            if path.length - s < self.settings.arrival or math.hypot(x - pose.x, y - pose.y) < self.settings.arrival:
                self._stretches.pop(0)
                continue
            self._progress = s
            if not self._turn_towards(pose.heading + self._error(path, s, pose, past_end=False), pose):
                self._enter_drive()
            return
        self._enter("face")

    def _error(self, path: Polyline, s: float, pose: Pose2, past_end: bool = True) -> float:
        """Radians from the heading to the point aimed at, less what curves on the way there turn anyway."""
        reach = s + self.settings.lookahead
        x, y = path.at(reach if past_end else min(reach, path.length))
        error = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.heading)
        if isinstance(path, Curve) and path.curved_within(s, reach):
            count = 8
            ways = [s + self.settings.lookahead * (number + 0.5) / count for number in range(count)]
            error -= sum(path.turned(way) for way in ways) / count - path.turned(s)
        return wrap_angle(error)

    def _enter_drive(self) -> None:
        progress = self._progress
        self._enter("drive")
        self._progress = progress

    def _face(self, pose: Pose2) -> None:
        if self._final_heading is None or not self._turn_towards(self._final_heading, pose):
            self._enter("done")

    def _turn_towards(self, heading: float, pose: Pose2) -> bool:
        """Plans a turn on the spot; False when the heading is good enough."""
        error = wrap_angle(heading - pose.heading)
        if abs(error) <= self.settings.heading_tolerance or self._tries >= self.settings.turn_tries:
            return False
        self._tries += 1
        angle = error / self.slip.turn
        self._turn = (angle, pose.heading)
        profile = to_position(Axis(), angle, self.vehicle.heading)
        self._pending = split(run(merge(None, profile)), round(self.settings.chunk * 1e6))
        return True

    def _drive(self, now: float, pose: Pose2, committed: CommittedMotion) -> None:
        """Plans the next chunk of driving, or the last one with the rest at its end."""
        settings = self.settings
        path = self._stretches[0]
        end = committed.end_state
        turn_scale = self.slip.turn if isinstance(path, Curve) else 1.0
        curved = isinstance(path, Curve) and path.curved_within(self._progress - 0.4, self._progress)
        self.slip.driving(now, pose, committed, curved)
        ahead = dead_reckon(
            pose,
            committed.increments(now, committed.end_time),
            scale=self.slip.scale,
            drift=self.slip.drift,
            turn_scale=turn_scale,
        )
        s, self.cross_track = path.project(ahead.x, ahead.y, self._progress - 0.1, self._progress + 0.3)
        s = self._filtered(path, s, end)
        self._progress = max(self._progress, min(s, path.length))
        error = self._error(path, s, ahead)
        if abs(self.cross_track) > settings.max_off_path or abs(error) > MAX_STEERING_RAD:
            self._give_up(committed)
            return
        error -= self.slip.drift * end.speed * settings.chunk
        if isinstance(path, Curve):
            travel, last, heading = self._curve(path, s, end, error)
        else:
            travel, last = self._travel(path, s, end), True
            heading = to_position(Axis(0.0, end.turn_rate, end.turn_acceleration), error, settings.steering)
        if not last or travel.duration > 1.75 * settings.chunk:
            segments = merge(travel, heading, until=settings.chunk)
        else:
            segments = merge(travel, heading)
            segments = [*segments[:-1], replace(segments[-1], rest=True)] if segments else []
            self._stretches.pop(0)
            self._restarts_here = 0
            self._enter("aim" if self._stretches else "face")
        if segments and end.at_rest:
            segments = [replace(segments[0], begin=True), *segments[1:]]
        self._pending = segments

    def _filtered(self, path: Polyline, s: float, end: State) -> float:
        """Where on a curve the rover is: mostly what was driven since the last look, a third what is seen now."""
        if not isinstance(path, Curve):
            return s
        if self._along is not None:
            travel, before = self._along
            driven = before + self.slip.scale * (end.travel - travel)
            s = driven + 0.3 * (s - driven)
        self._along = (end.travel, s)
        return s

    def _curve(self, path: Curve, s: float, end: State, error: float) -> tuple[Profile, bool, Profile]:
        """Travel, whether it ends at rest, and heading: the curve's own turning and the steering on top of it."""
        chunk = self.settings.chunk
        braking = stop_distance(end.speed, end.acceleration, self.limits)
        rest = max(self._rest_target(path, s, end, braking) - end.travel, 0.0)
        axis = Axis(0.0, end.speed, end.acceleration)
        limits = replace(self.limits, speed=self._speed(path, s, braking))
        travel, last = path.travel_profile(s, axis, rest, limits, self.slip.scale, 2.0 * chunk)
        ground_speed = 0.5 * self.slip.scale * (end.speed + speed_after(travel, axis, chunk))
        curvature, slope = path.turning(s)
        turn_scale = self.slip.turn
        rate = end.turn_rate - curvature * ground_speed / turn_scale
        acceleration = end.turn_acceleration - slope * ground_speed**2 / turn_scale
        nominal = [
            (time, jerk / turn_scale)
            for time, jerk in path.heading_profile(s, ground_speed, min(travel.duration, 2.0 * chunk))
        ]
        steered = to_position(Axis(0.0, rate, acceleration), error, self._steering)
        return travel, last, Profile(together(nominal, steered.pieces), 0.0, 0.0)

    def _travel(self, path: Polyline, s: float, end: State) -> Profile:
        """To the end of the stretch; once braking is near, to the same place every time."""
        braking = stop_distance(end.speed, end.acceleration, self.limits)
        distance = self._rest_target(path, s, end, braking) - end.travel
        limits = replace(self.limits, speed=self._speed(path, s, braking))
        profile = to_position(Axis(0.0, end.speed, end.acceleration), distance, limits)
        if profile.highest > distance + 0.002:  # it would overshoot and come back
            return stop_profile(end.speed, end.acceleration, self.limits)
        return profile

    def _rest_target(self, path: Polyline, s: float, end: State, braking: float) -> float:
        """The commanded travel at which the stretch ends."""
        seen = end.travel + (path.length - s) / self.slip.scale
        if not self._braking:
            # Every look is a fresh measurement of the same place: the mean is better than the last.
            before = seen if self._target is None else self._target
            self._target = max(before + 0.3 * (seen - before), end.travel + braking)
            self._braking = self._target - end.travel < braking + 1.5 * self.settings.chunk * end.speed + 0.01
        return seen if self._target is None else self._target

    def _speed(self, path: Polyline, s: float, braking: float) -> float:
        limit = self.speed_limit
        if limit is None:
            return self.limits.speed
        if not callable(limit):
            return max(min(limit, self.limits.speed), self.settings.min_speed)
        lowest = self.limits.speed
        ahead = braking + 0.1
        for number in range(1 + math.ceil(ahead / 0.05)):
            x, y = path.at(min(s + 0.05 * number, path.length))
            lowest = min(lowest, limit(x, y))
        return max(lowest, self.settings.min_speed)

    @property
    def committed_at_most(self) -> float:
        """Seconds that can be committed ahead at any time."""
        return self.settings.horizon + 2.0 * self.settings.chunk
