"""The rover's pose: wheels between frames, frames against keyframes, refused when they can't be trusted.

    clean → lay on the ground → ORB → match with keyframes → DBSCAN → PnP → gate → correct

The filter stands at the time of the last frame; what the wheels said since is applied on top for whoever asks. A frame
that arrives late therefore needs no undoing: the filter moves up to its exposure, takes it in, and that is all.
Without wheels (`motion="frames"`) speed and turn rate are part of the state, and frames alone correct them.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2, wrap_angle
from rover.vehicle import STANDARD
from rover.vision.camera.model import CameraModel
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.localization.keyframes import Keyframe, KeyframeSettings, KeyframeStore
from rover.vision.localization.motion_history import MotionHistory
from rover.vision.localization.motion_model import FreeMotionNoise, MotionNoise, advance, advance_freely
from rover.vision.localization.observation import Mark, Observation, Observer, no_mark
from rover.vision.localization.placement import Placement, PlacementSettings, place, search_area
from rover.vision.localization.pose_filter import Moved, PoseFilter
from rover.vision.localization.relocation import Proposal, RelocationSettings, propose, same_place
from rover.vision.registration.features import FeatureSettings
from rover.vision.registration.preprocess import PreprocessSettings

Array = NDArray[np.float64]

# 1σ of x, y (m) and heading (rad) while the place is not known at all: more than any field that is mapped.
NOWHERE = (10.0, 10.0, 3.0)


@dataclass(frozen=True)
class LocalizerSettings:
    """motion: what moves the pose between frames, the wheels or nothing but frames.

    gate: squared Mahalanobis distance up to which a pose is believed (99.9 % of three degrees of freedom).
    floor: 1σ of x, y (m) and heading (rad) that no single frame is better than. blur: the same of a keyframe's own
    features, shared by all fixes against it; blur_alone: without wheels that hold keyframes together.
    doubt: the same, added for each frame that contradicts what is believed.
    lost_after: contradicting frames in a row after which the rover counts as lost.
    """

    motion: Literal["wheels", "frames"] = "wheels"
    track_width: float = STANDARD.track_width
    gate: float = 16.3
    floor: tuple[float, float, float] = (0.0015, 0.0015, 0.0017)
    blur: tuple[float, float, float] = (0.0022, 0.0022, 0.0038)
    blur_alone: tuple[float, float, float] = (0.005, 0.005, 0.0085)
    doubt: tuple[float, float, float] = (0.02, 0.02, 0.02)
    lost_after: int = 3
    max_lag: float = 1.0
    preprocess: PreprocessSettings = field(default_factory=lambda: PreprocessSettings(gaussian_sigma=0.7))
    features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=160, levels=1, surplus=2))
    keyframe_features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=400, levels=1, surplus=2))
    placement: PlacementSettings = field(default_factory=PlacementSettings)
    relocation: RelocationSettings = field(default_factory=RelocationSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    noise: MotionNoise = field(default_factory=MotionNoise)
    free_noise: FreeMotionNoise = field(default_factory=FreeMotionNoise)

    @property
    def motion_sigma(self) -> tuple[float, float]:
        """Standard deviations of the two numbers of motion while nothing is known."""
        if self.motion == "wheels":
            return self.noise.slip_start, self.noise.slip_start
        return self.free_noise.speed, self.free_noise.turn


@dataclass(frozen=True)
class Fix:
    """What became of one frame. Pose in map (metres, radians) as the frame alone says; reason: why it was refused."""

    time: float
    accepted: bool
    reason: str = ""
    keypoints: int = 0
    matches: int = 0
    inliers: int = 0
    residual_px: float = 0.0
    x: float = math.nan
    y: float = math.nan
    heading: float = math.nan
    keyframe: bool = False


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
        self.keyframes = KeyframeStore(camera, s.keyframes)
        self.filter = PoseFilter(start, start_sigma, s.motion_sigma)
        self._history = MotionHistory()
        self._observer = Observer(camera, s.preprocess, s.features, s.keyframe_features)
        self._mark = mark
        self._filter_time = -math.inf
        self._front = self._at_filter()
        # Keyframes that show the ground around the rover, as of the last frame.
        self._near: list[int] = []
        self._past: deque[tuple[float, Array]] = deque(maxlen=100)
        self._contradicted = 0
        self._proposal: Proposal | None = None
        self._placed = known is None
        if known is not None:
            self._begin_lost(known)

    @property
    def pose(self) -> Pose2:
        """The newest pose in map."""
        return _pose(self._front.robot)

    @property
    def covariance(self) -> Array:
        """(3, 3) of x, y, heading of the newest pose in map: it grows with the way from the launch."""
        moved = self._front
        covariance: Array = (moved.jacobian @ self.filter.robot_covariance @ moved.jacobian.T + moved.added)[:3, :3]
        return covariance

    @property
    def relative_covariance(self) -> Array:
        """(3, 3) of x, y, heading of the newest pose in the frame of a keyframe, in that keyframe's axes.

        Of the keyframes that show the ground around the rover it is the one to which the rover is known best: what was
        mapped there was mapped from it. Before the first keyframe it is that of the pose in map.
        """
        found = [self.filter.relative_covariance(index, self._front) for index in self._near]
        return min(found, key=lambda one: float(one[0, 0] + one[1, 1]), default=self.covariance)

    @property
    def lost(self) -> bool:
        """True once frames have contradicted what is believed too often in a row, until they show a known place."""
        return self._contradicted >= self.settings.lost_after

    @property
    def map(self) -> KeyframeMap:
        """All keyframes as they are believed to lie, for a next run."""
        return KeyframeMap(
            list(self.keyframes.frames), self.filter.keyframe_poses().copy(), self.filter.keyframe_covariance
        )

    def _begin_lost(self, known: KeyframeMap) -> None:
        self.filter.doubt(NOWHERE)
        self.filter.add_known(known.poses, known.covariance)
        for count, frame in enumerate(known.frames, start=1):
            self.keyframes.add(frame, known.poses[:count])
        self._contradicted = self.settings.lost_after
        self._catch_up()

    def predict(self, time: float, left: float, right: float) -> None:
        """Wheel travel in metres that ends at `time`. Raises ValueError where motion comes from frames alone."""
        if self.settings.motion == "frames":
            raise ValueError("wheel travel for a localizer that is to work on frames alone")
        travel = self._history.add(time, left, right)
        self._step_front(travel.left, travel.right)
        turn = (right - left) / self.settings.track_width
        ahead, middle = 0.5 * (left + right), self.odometry_only.heading + 0.5 * turn
        self.odometry_only = Pose2(
            self.odometry_only.x + ahead * math.cos(middle),
            self.odometry_only.y + ahead * math.sin(middle),
            wrap_angle(self.odometry_only.heading + turn),
        )
        if not math.isfinite(self._filter_time):
            self._filter_time = travel.begin
        if time - self._filter_time > self.settings.max_lag:
            self._move_filter(time - 0.5 * self.settings.max_lag)
            self._catch_up()

    def pose_at(self, time: float) -> Pose2:
        """The pose at a time of the last two seconds; the newest for later ones, the oldest kept for earlier ones."""
        if time >= self._filter_time:
            robot = self.filter.mean[:5]
            if self.settings.motion == "frames" and math.isfinite(self._filter_time):
                robot, _, _ = advance_freely(robot, time - self._filter_time, self.settings.free_noise)
            for travel in self._history.until(time):
                robot, _, _ = self._advance(robot, travel.left, travel.right)
            return _pose(robot)
        later = (self._filter_time, self.filter.mean[:3])
        for earlier in reversed(self._past):
            if earlier[0] <= time:
                span = later[0] - earlier[0]
                share = (time - earlier[0]) / span if span > 0.0 else 0.0
                return _pose(earlier[1][:3] + share * (later[1][:3] - earlier[1][:3]))
            later = earlier
        return _pose(later[1])

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
        return fix

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
        if fix.accepted:
            self._contradicted, self._proposal = 0, None
        else:
            fix = self._relocate(time, seen, fix)
            waits = self._proposal is not None or self.lost or self.settings.motion == "frames"
            if not fix.accepted and unknown and not waits:
                fix = replace(fix, reason="new ground: placed by the wheels", keyframe=True)
        if fix.keyframe or (fix.accepted and overlap.max() < self.settings.keyframes.sparse):
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

    def _relocate(self, time: float, seen: Observation, refused: Fix) -> Fix:
        """After a frame that fits nothing expected: do the keyframes know its place, and did the last frame say so?"""
        s = self.settings
        blind = (0.0, 0.0) if s.motion == "wheels" else (s.noise.uncovered_speed, s.noise.uncovered_turn)
        poses = self.filter.keyframe_poses()
        proposal = propose(
            time, seen, self.keyframes, poses, self.filter.pose, self.camera, s.placement, s.relocation, self._mark
        )
        former, self._proposal = self._proposal, proposal
        if proposal is not None and former is not None and same_place(former, proposal, *blind, s.relocation):
            self._contradicted, self._proposal = 0, None
            if s.motion == "frames":
                self.filter.stop(s.motion_sigma)
            noise = proposal.found.covariance + np.diag(np.square(s.floor))
            self.filter.relocate(proposal.index, proposal.found.pose, noise)
            if not self._placed:
                self._placed, self.odometry_only = True, self.filter.pose
            made = Placement(proposal.matches, proposal.found)
            return self._fix(time, True, "relocated", seen, made, proposal.index)
        if proposal is not None or refused.reason != "new ground" or s.motion == "frames":
            self._contradicted += 1
            self.filter.doubt(s.doubt)
        return refused

    def _keep(self, time: float) -> None:
        seen = self._observer.look_closer()
        if len(self.keyframes) >= self.settings.keyframes.limit:
            index = self.keyframes.redundant()
            self.filter.drop_keyframe(index)
            self.keyframes.drop(index)
        blur = self.settings.blur if self.settings.motion == "wheels" else self.settings.blur_alone
        self.filter.add_keyframe(np.diag(np.square(blur)))
        self.keyframes.add(Keyframe(seen.ground, seen.descriptors, seen.pixel_m, time), self.filter.keyframe_poses())
        self._mark("keyframe")

    def _fix(self, time: float, accepted: bool, reason: str, seen: Observation, made: Placement, index: int) -> Fix:
        assert made.found is not None
        at = self.filter.keyframe_pose(index).compose(made.found.pose)
        count, residual = made.found.count, made.found.residual_px
        return Fix(time, accepted, reason, len(seen), made.matches, count, residual, at.x, at.y, at.heading)

    def _advance(self, robot: Array, left: float, right: float) -> tuple[Array, Array, Array]:
        return advance(robot, left, right, self.settings.track_width, self.settings.noise)

    def _move_filter(self, time: float) -> None:
        """The filter up to `time` by all wheel reports until then; what none covers adds uncertainty."""
        self._past.append((self._filter_time, self.filter.mean[:3].copy()))
        if self.settings.motion == "frames":
            if math.isfinite(self._filter_time):
                self.filter.propagate(*advance_freely(self.filter.mean[:5], time - self._filter_time,
                                                      self.settings.free_noise))  # fmt: skip
            self._filter_time = time
            return
        robot = self.filter.mean[:5].copy()
        jacobian, added = np.eye(5), np.zeros((5, 5))
        for travel in self._history.take_until(time):
            if travel.left == 0.0 and travel.right == 0.0:
                continue
            robot, step, noise = self._advance(robot, travel.left, travel.right)
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
        """Which keyframes show the ground that is in view now; where none does, those in view before stay."""
        overlap = self.keyframes.overlap(self.filter.mean[:3], self.filter.keyframe_poses())
        near = np.flatnonzero(overlap >= self.settings.keyframes.enough).tolist()
        self._near = near or self._near

    def _at_filter(self) -> Moved:
        return Moved(self.filter.mean[:5].copy(), np.eye(5), np.zeros((5, 5)))

    def _step_front(self, left: float, right: float) -> None:
        if left == 0.0 and right == 0.0:
            return
        self._front = self._front.then(*self._advance(self._front.robot, left, right))

    def _catch_up(self) -> None:
        """The newest pose from the corrected filter and the wheel reports that came after the frame."""
        self._front = self._at_filter()
        for travel in self._history.until(math.inf):
            self._step_front(travel.left, travel.right)


def _pose(state: Array) -> Pose2:
    return Pose2(float(state[0]), float(state[1]), wrap_angle(float(state[2])))
