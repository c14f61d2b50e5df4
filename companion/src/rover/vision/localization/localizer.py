"""The rover's pose: wheels between frames, frames against keyframes, refused when they can't be trusted.

    clean → lay on the ground → ORB → match with keyframes → DBSCAN → PnP → gate → correct

The filter stands at the time of the last frame; what the wheels said since is applied on top for whoever asks. A frame
that arrives late therefore needs no undoing: the filter moves up to its exposure, takes it in, and that is all.
Without wheels (`motion="frames"`) speed and turn rate are part of the state, and frames alone correct them.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2, between, wrap_angle
from rover.vision.camera.model import CameraModel
from rover.vision.localization.atlas import Atlas
from rover.vision.localization.fix import Fix
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.localization.keyframes import Keyframe, KeyframeStore
from rover.vision.localization.motion_history import MotionHistory, Travel
from rover.vision.localization.motion_model import ROBOT, advance, advance_freely, advance_turned, rolled
from rover.vision.localization.observation import Mark, Observation, Observer, no_mark
from rover.vision.localization.placement import Placement, place, search_area
from rover.vision.localization.pose_filter import Moved, PoseFilter, difference
from rover.vision.localization.relocation import Proposal, convincing, propose, same_place
from rover.vision.localization.settings import NOWHERE, LocalizerSettings

Array = NDArray[np.float64]


class Localizer:
    """Pose of base_link in map with its covariance; the pose from the wheels alone is kept beside it."""

    def __init__(
        self,
        camera: CameraModel,
        start: Pose2,
        start_sigma: tuple[float, float, float],
        settings: LocalizerSettings | None = None,
        mark: Mark = no_mark,
        known: KeyframeMap | None = None,
    ) -> None:
        """known: keyframes of a former run. With them `start` counts for nothing: lost until a place is recognised."""
        self.settings = s = settings or LocalizerSettings()
        self.camera = camera
        self.odometry_only = start
        self.atlas = Atlas(camera, s.keyframes, start, start_sigma, s.motion_sigma, s.mount_sigma)
        self._history = MotionHistory()
        self._observer = Observer(camera, s.preprocess, s.features, s.keyframe_features)
        self._mark = mark
        self._filter_time = -math.inf
        self._front = self._at_filter()
        # Of the keyframes that show the ground in view, the one to which the rover was known best at the last frame.
        self._near: int | None = None
        # Time, submap, and pose (3,) in that submap.
        self._past: deque[tuple[float, int, Array]] = deque(maxlen=100)
        self._contradicted = 0
        self._proposal: Proposal | None = None
        self._asked = 0
        self._placed = known is None
        if known is not None:
            self._begin_lost(known)

    @property
    def filter(self) -> PoseFilter:
        """Of the submap that the rover is in, in that submap's frame."""
        return self.atlas.here.filter

    @property
    def keyframes(self) -> KeyframeStore:
        """Of the submap that the rover is in."""
        return self.atlas.here.keyframes

    @property
    def pose(self) -> Pose2:
        """The newest pose in map."""
        return self._in_map(_pose(self._front.robot))

    @property
    def time(self) -> float:
        """When the newest pose was: at the end of the last wheel report, or of the last frame."""
        return max(self._filter_time, self._history.newest)

    @property
    def covariance(self) -> Array:
        """(3, 3) of x, y, heading of the newest pose in map: it grows with the way from the launch."""
        inside = self._front_covariance
        return self.atlas.graph.lifted(self.atlas.active, _pose(self._front.robot), inside)[1]

    @property
    def _front_covariance(self) -> Array:
        moved = self._front
        covariance: Array = (moved.jacobian @ self.filter.robot_covariance @ moved.jacobian.T + moved.added)[:3, :3]
        return covariance

    @property
    def relative_covariance(self) -> Array:
        """(3, 3) of x, y, heading of the newest pose in the frame of a keyframe, in that keyframe's axes.

        Of the keyframes that show the ground around the rover it is the one to which the rover is known best: what was
        mapped there was mapped from it. Before the first keyframe it is that of the pose in map.
        """
        if self._near is None:
            return self._front_covariance
        return self.filter.relative_covariance(self._near, self._front)

    def tie(self, point: tuple[float, float], sigma: float, known: tuple[float, float]) -> None:
        """A point (base_link, metres, 1σ) of the frame that was just observed is one of known place in map."""
        self.atlas.tie(point, sigma, known)

    def as_seen_with(self, point: tuple[float, float], submap: int) -> tuple[float, Pose2, Array] | None:
        """The newest pose in the frame of the first keyframe of a submap that shows a point of the map.

        Returns the keyframe's time, the pose, and the covariance (2, 2) of its position; None where no keyframe of
        this run shows the point.
        """
        return self.atlas.as_seen_with(point, submap, self._front)

    @property
    def lost(self) -> bool:
        """True once frames have contradicted what is believed too often in a row, until they show a known place."""
        return self._contradicted >= self.settings.lost_after

    @property
    def map(self) -> KeyframeMap:
        """All keyframes as they are believed to lie, for a next run."""
        return self.atlas.map

    def lose(self) -> None:
        """Somebody has moved the rover: lost, until frames show a known place."""
        self._contradicted = max(self._contradicted, self.settings.lost_after)
        self.filter.doubt(NOWHERE)
        self._catch_up()

    def _begin_lost(self, known: KeyframeMap) -> None:
        self.atlas.restore(known, self.settings.motion_sigma, NOWHERE)
        self._contradicted = self.settings.lost_after
        self._catch_up()

    def predict(self, time: float, left: float, right: float, turn: float | None = None) -> None:
        """Wheel travel in metres that ends at `time`; turn: what a gyroscope turned by, radians, where there is one.

        Raises ValueError where motion comes from frames alone.
        """
        if self.settings.motion == "frames":
            raise ValueError("wheel travel for a localizer that is to work on frames alone")
        travel = self._history.add(time, left, right, turn)
        self._step_front(travel)
        self.odometry_only = rolled(self.odometry_only, left, right, self.settings.track_width)
        if not math.isfinite(self._filter_time):
            self._filter_time = travel.begin
        if time - self._filter_time > self.settings.max_lag:
            self._move_filter(time - 0.5 * self.settings.max_lag)
            self._catch_up()

    def pose_at(self, time: float) -> Pose2:
        """The pose at a time of the last two seconds; the newest for later ones, the oldest kept for earlier ones."""
        if time >= self._filter_time:
            robot = self.filter.mean[:ROBOT]
            if self.settings.motion == "frames" and math.isfinite(self._filter_time):
                robot, _, _ = advance_freely(robot, time - self._filter_time, self.settings.free_noise)
            for travel in self._history.until(time):
                robot, _, _ = self._advance(robot, travel)
            return self._in_map(_pose(robot))
        later = (self._filter_time, self._in_map(_pose(self.filter.mean)))
        for at, submap, state in reversed(self._past):
            earlier = (at, self.atlas.graph.poses[submap].compose(_pose(state)))
            if at <= time:
                span = later[0] - at
                return between(earlier[1], later[1], (time - at) / span if span > 0.0 else 0.0)
            later = earlier
        return later[1]

    def view_at(self, time: float) -> Pose2:
        """`pose_at`, shifted by the camera's offset: from there the ground lies where the picture shows it."""
        ahead, left = self.filter.offset.tolist()
        return self.pose_at(time).compose(Pose2(-ahead, -left, 0.0))

    @property
    def offset(self) -> tuple[float, float]:
        """How far the camera shows the ground off where it is, metres, and the larger 1σ of that."""
        spread = float(np.linalg.eigvalsh(self.filter.offset_covariance)[1])
        return float(np.hypot(*self.filter.offset)), math.sqrt(max(spread, 0.0))

    def inside(self, pose: Pose2) -> Pose2:
        """A pose in map, in the frame of the submap that the rover is in."""
        return pose.relative_to(self.atlas.graph.poses[self.atlas.active])

    def observe(self, frame: Frame) -> Fix:
        """Takes one frame, exposed at `frame.time`. What is refused leaves the pose to the wheels."""
        if frame.ffc:
            self._observer.forget()
            return Fix(frame.time, False, "shutter closed")
        if frame.time < self._filter_time:
            return Fix(frame.time, False, "older than a frame before")
        seen = self._observer.look(frame, self._mark)
        self._move_filter(frame.time)
        self._mark("filter")
        fix = self._locate(frame.time, seen)
        self._look_around()
        self._catch_up()
        self._mark("filter")
        offset, spread = self.offset
        return replace(fix, offset=offset, offset_sigma=spread)

    def _locate(self, time: float, seen: Observation) -> Fix:
        found = len(seen)
        if found < self.settings.placement.ground_pose.min_inliers:
            return Fix(time, False, "too little texture", found)
        if len(self.keyframes) == 0:
            self._keep(time)
            return Fix(time, True, "first", found, keyframe=True)
        overlap = self.keyframes.overlap(self.filter.mean[:3], self.filter.keyframe_poses())
        self._mark("filter")
        fix = Fix(time, False, "new ground" if self._placed else "place not recognised yet", found)
        for index in self.keyframes.candidates(overlap) if self._placed else ():
            fix = self._correct(time, seen, index)
            if fix.accepted:
                break
        unknown = overlap.max() < self.settings.keyframes.enough
        due = overlap.max() < self.settings.keyframes.sparse
        if due and (fix.accepted or (unknown and self._placed and not self.lost)):
            back = self._return(time, seen)
            if back is not None:
                self._contradicted, self._proposal = 0, None
                return back
        if fix.accepted:
            self._contradicted, self._proposal = 0, None
        else:
            fix = self._relocate(time, seen, fix)
            waits = self._proposal is not None or self.lost or self.settings.motion == "frames"
            if not fix.accepted and unknown and not waits:
                fix = replace(fix, reason="new ground: placed by the wheels", keyframe=True)
        if fix.keyframe or (fix.accepted and due and fix.reason != "relocated"):
            self._keep(time)
            return replace(fix, keyframe=True)
        return fix

    def _correct(self, time: float, seen: Observation, index: int) -> Fix:
        """One try against one keyframe near where the filter expects it."""
        s = self.settings
        expected, covariance, _ = self.filter.expected_fix(index)
        area = search_area(expected, covariance, s.placement)
        self._mark("filter")
        made = place(seen, self.keyframes.frames[index], self.camera, area, s.placement, self._mark)
        if made.found is None:
            return Fix(time, False, "too few matches agree", len(seen), made.matches)
        noise = made.found.covariance + np.diag(np.square(s.floor))
        believed = self.filter.update(index, made.found.pose, noise, s.gate)
        return self._fix(time, believed, "" if believed else "contradicts the wheels", seen, made, index)

    def _return(self, time: float, seen: Observation) -> Fix | None:
        """Ground that this submap does not know: does another one know it? Then the rover goes over into that one."""
        s = self.settings
        least = s.keyframes.enough if self._full else s.keyframes.sparse
        for known in self.atlas.elsewhere(least)[: s.keyframes.tries]:
            keyframe = self.atlas.submaps[known.submap].keyframes.frames[known.index]
            area = search_area(known.expected, known.covariance, s.placement)
            made = place(seen, keyframe, self.camera, area, s.placement, self._mark)
            if made.found is None or not convincing(made, s.relocation):
                continue
            noise = made.found.covariance + np.diag(np.square(s.floor))
            off = difference(made.found.pose, known.expected)
            if float(off @ np.linalg.solve(known.covariance + noise, off)) > s.gate:
                continue
            self.atlas.enter(known.submap, known.index, made.found.pose, noise, sure=True)
            fix = self._fix(time, True, "in another submap", seen, made, known.index)
            if known.overlap < s.keyframes.sparse and not self._full:
                self._keep(time)
                return replace(fix, keyframe=True)
            return fix
        return None

    def _relocate(self, time: float, seen: Observation, refused: Fix) -> Fix:
        """After a frame that fits nothing expected: do the keyframes know its place, and did the last frame say so?"""
        s = self.settings
        blind = (0.0, 0.0) if s.motion == "wheels" else (s.noise.uncovered_speed, s.noise.uncovered_turn)
        proposal = self._propose(time, seen)
        former, self._proposal = self._proposal, proposal
        if proposal is not None and former is not None and same_place(former, proposal, *blind, s.relocation):
            self._contradicted, self._proposal = 0, None
            if s.motion == "frames":
                self.filter.stop(s.motion_sigma)
            noise = proposal.found.covariance + np.diag(np.square(s.floor))
            self.atlas.enter(proposal.submap, proposal.index, proposal.found.pose, noise, sure=False)
            if not self._placed:
                self._placed, self.odometry_only = True, self._in_map(self.filter.pose)
            made = Placement(proposal.matches, proposal.found)
            return self._fix(time, True, "relocated", seen, made, proposal.index)
        if proposal is not None or refused.reason != "new ground" or s.motion == "frames":
            self._contradicted += 1
            self.filter.doubt(s.doubt)
        return refused

    def _propose(self, time: float, seen: Observation) -> Proposal | None:
        """A place in this submap or, once the rover is lost, in one other for each frame; again where the last was."""
        s, atlas = self.settings, self.atlas
        asked = [atlas.active]
        if self._proposal is not None:
            asked = [self._proposal.submap]
        elif self.lost and len(atlas.submaps) > 1:
            self._asked = (self._asked + 1) % len(atlas.submaps)
            asked = sorted({atlas.active, self._asked}, key=lambda number: number != atlas.active)
        for number in asked:
            submap = atlas.submaps[number]
            proposal = propose(
                time,
                seen,
                (number, submap.keyframes),
                submap.filter.keyframe_poses(),
                self.filter.pose,
                self.camera,
                s.placement,
                s.relocation,
                self._mark,
            )
            if number != atlas.active:
                submap.keyframes.forget_votes()
            if proposal is not None:
                return proposal
        return None

    def _keep(self, time: float) -> None:
        seen = self._observer.look_closer()
        if self._full:
            self.atlas.begin()
        blur = self.settings.blur if self.settings.motion == "wheels" else self.settings.blur_alone
        self.filter.add_keyframe(np.diag(np.square(blur)))
        self.keyframes.add(Keyframe(seen.ground, seen.descriptors, seen.pixel_m, time))
        self._mark("keyframe")

    @property
    def _full(self) -> bool:
        """True when this submap takes no further keyframe: it has enough, or would be no rigid piece any more."""
        (a, b), (_, d) = self.filter.pose_covariance[:2, :2].tolist()
        vague = 0.5 * (a + d) + math.hypot(0.5 * (a - d), b) > self.settings.rigid**2
        count = len(self.keyframes)
        return count >= self.settings.keyframes.limit or (vague and count > 0)

    def _in_map(self, inside: Pose2) -> Pose2:
        return self.atlas.graph.poses[self.atlas.active].compose(inside)

    def _fix(self, time: float, accepted: bool, reason: str, seen: Observation, made: Placement, index: int) -> Fix:
        assert made.found is not None
        at = self._in_map(self.filter.keyframe_pose(index).compose(made.found.pose))
        count, residual = made.found.count, made.found.residual_px
        return Fix(time, accepted, reason, len(seen), made.matches, count, residual, at.x, at.y, at.heading)

    def _advance(self, robot: Array, travel: Travel) -> tuple[Array, Array, Array]:
        s = self.settings
        if travel.turn is None:
            return advance(robot, travel.left, travel.right, s.track_width, s.noise)
        return advance_turned(robot, travel, travel.turn, s.track_width, s.noise, s.gyro)

    def _move_filter(self, time: float) -> None:
        """The filter up to `time` by all wheel reports until then; what none covers adds uncertainty."""
        self._past.append((self._filter_time, self.atlas.active, self.filter.mean[:3].copy()))
        if self.settings.motion == "frames":
            if math.isfinite(self._filter_time):
                self.filter.propagate(*advance_freely(self.filter.mean[:ROBOT], time - self._filter_time,
                                                      self.settings.free_noise))  # fmt: skip
            self._filter_time = time
            return
        robot = self.filter.mean[:ROBOT].copy()
        jacobian, added = np.eye(ROBOT), np.zeros((ROBOT, ROBOT))
        for travel in self._history.take_until(time):
            if travel.still:
                continue
            robot, step, noise = self._advance(robot, travel)
            jacobian = step @ jacobian
            added = step @ added @ step.T + noise
        reached = max(self._filter_time, self._history.newest)
        if math.isfinite(reached) and time > reached:
            blind = time - reached
            moved = (self.settings.noise.uncovered_speed * blind) ** 2
            added[:3, :3] += np.diag((moved, moved, (self.settings.noise.uncovered_turn * blind) ** 2))
        self.filter.propagate(robot, jacobian, added)
        self._filter_time = max(time, self._filter_time)

    def _look_around(self) -> None:
        """Which keyframe that shows the ground in view tells best where the rover is; where none does, the last one."""
        overlap = self.keyframes.overlap(self.filter.mean[:3], self.filter.keyframe_poses())
        near = np.flatnonzero(overlap >= self.settings.keyframes.enough).tolist()
        if not near:
            self._near = None if self._near is not None and self._near >= len(self.keyframes) else self._near
            return
        spreads = [float(self.filter.relative_covariance(index)[:2, :2].trace()) for index in near]
        self._near = near[int(np.argmin(spreads))]

    def _at_filter(self) -> Moved:
        return Moved(self.filter.mean[:ROBOT].copy(), np.eye(ROBOT), np.zeros((ROBOT, ROBOT)))

    def _step_front(self, travel: Travel) -> None:
        if travel.still:
            return
        self._front = self._front.then(*self._advance(self._front.robot, travel))

    def _catch_up(self) -> None:
        """The newest pose from the corrected filter and the wheel reports that came after the frame."""
        self._front = self._at_filter()
        for travel in self._history.until(math.inf):
            self._step_front(travel)


def _pose(state: Array) -> Pose2:
    return Pose2(float(state[0]), float(state[1]), wrap_angle(float(state[2])))
