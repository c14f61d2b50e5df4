"""The rover's pose: wheels between frames, frames against keyframes, refused when they can't be trusted.

    clean → lay on the ground → ORB → match with keyframes → DBSCAN → PnP → gate → correct

The filter stands at the time of the last frame; what the wheels said since is applied on top for whoever asks. A frame
that arrives late therefore needs no undoing: the filter moves up to its exposure, takes it in, and that is all.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2, wrap_angle
from rover.vision.camera import CameraModel
from rover.vision.cluster import NOISE, dbscan
from rover.vision.features import FeatureDetector, Features, FeatureSettings
from rover.vision.ground_pose import GroundPose, GroundPoseSettings, metres_per_pixel, solve_ground_pose
from rover.vision.ground_view import GroundView
from rover.vision.keyframes import Keyframe, KeyframeSettings, KeyframeStore
from rover.vision.matching import MatchSettings, hamming, mutual_matches, signs
from rover.vision.motion_history import MotionHistory
from rover.vision.pose_filter import MotionNoise, PoseFilter, advance
from rover.vision.preprocess import Preprocessor, PreprocessSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalizerSettings:
    """search: metres around its expected place in which a feature is looked for, beyond three sigma.

    gate: squared Mahalanobis distance up to which a pose is believed (99.9 % of three degrees of freedom).
    floor: 1σ of x, y (m) and heading (rad) that no single frame is better than. blur: the same of a keyframe's own
    features, shared by all fixes against it. epsilon, min_points: of DBSCAN, metres on the ground.
    lost_after: refused frames in a row after which the rover counts as lost. relocation_inliers: what it takes to
    believe a place without an expectation. relocation_tries: keyframes asked for one frame while lost.
    """

    track_width: float = 0.20
    search: float = 0.04
    gate: float = 16.3
    floor: tuple[float, float, float] = (0.002, 0.002, 0.002)
    blur: tuple[float, float, float] = (0.002, 0.002, 0.002)
    epsilon: float = 0.16
    min_points: int = 5
    lost_after: int = 10
    relocation_inliers: int = 25
    relocation_tries: int = 6
    max_lag: float = 1.0
    preprocess: PreprocessSettings = field(default_factory=PreprocessSettings)
    features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=220, levels=1))
    match: MatchSettings = field(default_factory=MatchSettings)
    ground_pose: GroundPoseSettings = field(default_factory=GroundPoseSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    noise: MotionNoise = field(default_factory=MotionNoise)


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


@dataclass(frozen=True, eq=False)
class _Seen:
    """One frame's features: ground (N, 2) in base_link, descriptors as ±1, metres per pixel where they lie."""

    ground: Array
    signs: NDArray[np.float32]
    pixel_m: Array


class Localizer:
    """Pose of base_link in map with its covariance; the pose from the wheels alone is kept beside it."""

    def __init__(
        self,
        camera: CameraModel,
        start: Pose2,
        start_sigma: tuple[float, float, float],
        settings: LocalizerSettings | None = None,
    ) -> None:
        self.settings = s = settings or LocalizerSettings()
        self.camera = camera
        self.odometry_only = start
        self.keyframes = KeyframeStore(camera, s.keyframes)
        self.filter = PoseFilter(start, start_sigma, s.noise)
        self._history = MotionHistory()
        self._view = GroundView(camera)
        self._preprocess = Preprocessor(s.preprocess)
        self._detector = FeatureDetector(s.features)
        self._filter_time = -math.inf
        self._front = self.filter.mean[:5].copy()
        self._front_covariance = self.filter.robot_covariance
        self._past: deque[tuple[float, Array]] = deque(maxlen=100)
        self._refused = 0
        self._relocation_next = 0

    @property
    def pose(self) -> Pose2:
        """The newest pose in map."""
        return _pose(self._front)

    @property
    def covariance(self) -> Array:
        """(3, 3) of x, y, heading of the newest pose."""
        return self._front_covariance[:3, :3].copy()

    @property
    def lost(self) -> bool:
        """True while frames contradict what is believed, or show nothing known, for too long."""
        return self._refused >= self.settings.lost_after

    def predict(self, time: float, left: float, right: float) -> None:
        """Wheel travel in metres that ends at `time`."""
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

    def pose_at(self, time: float) -> Pose2:
        """The pose at a time of the last two seconds; the newest for later ones, the oldest kept for earlier ones."""
        if time >= self._filter_time:
            robot = self.filter.mean[:5]
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
            self._preprocess.forget()
            return Fix(frame.time, False, "shutter closed")
        if frame.time < self._filter_time:
            return Fix(frame.time, False, "older than a frame before")
        seen = self._look(frame)
        self._move_filter(frame.time)
        fix = self._locate(frame.time, seen)
        self._refused = 0 if fix.accepted else self._refused + 1
        self._catch_up()
        return fix

    def _look(self, frame: Frame) -> _Seen:
        picture = self._preprocess.to_8_bit(self._view.look(self._preprocess.clean(frame.counts)))
        features: Features = self._detector.detect(picture, self._view.mask)
        ground = self._view.to_base(features.points)
        _, depth = self.camera.ground_to_normalized(ground)
        return _Seen(ground, signs(features.descriptors), metres_per_pixel(depth, self.camera))

    def _locate(self, time: float, seen: _Seen) -> Fix:
        found = len(seen.ground)
        if found < self.settings.ground_pose.min_inliers:
            return Fix(time, False, "too little texture", found)
        if len(self.keyframes) == 0:
            self._keep(time, seen)
            return Fix(time, True, "first", found, keyframe=True)
        if self.lost:
            return self._relocate(time, seen)
        overlap = self.keyframes.overlap(self.filter.mean[:3], self.filter.keyframe_poses())
        fix = Fix(time, False, "new ground: placed by the wheels", found)
        for index in self.keyframes.candidates(overlap):
            fix = self._correct(time, seen, index)
            if fix.accepted:
                break
        new = overlap.max() < self.settings.keyframes.sparse
        if new and (fix.accepted or overlap.max() < self.settings.keyframes.enough):
            self._keep(time, seen)
            fix = Fix(**{**fix.__dict__, "keyframe": True})
        return fix

    def _correct(self, time: float, seen: _Seen, index: int) -> Fix:
        """One try against one keyframe near where the filter expects it."""
        expected, covariance, _ = self.filter.expected_fix(index)
        matches, found = self._place(seen, self.keyframes.frames[index], expected, covariance)
        if found is None:
            return Fix(time, False, "too few matches agree", len(seen.ground), matches)
        noise = found.covariance + np.diag(np.square(self.settings.floor))
        _, distance = self.filter.innovation(index, found.pose, noise)
        if distance > self.settings.gate:
            return self._fix(time, False, "contradicts the wheels", seen, matches, found, index)
        self.filter.update(index, found.pose, noise)
        return self._fix(time, True, "", seen, matches, found, index)

    def _relocate(self, time: float, seen: _Seen) -> Fix:
        """Asks the next few keyframes without any expectation; the best place wins if enough speaks for it."""
        best: tuple[int, int, GroundPose] | None = None
        for _ in range(min(self.settings.relocation_tries, len(self.keyframes))):
            index = self._relocation_next % len(self.keyframes)
            self._relocation_next += 1
            matches, found = self._place(seen, self.keyframes.frames[index], None, None)
            if found is not None and (best is None or found.count > best[2].count):
                best = (index, matches, found)
        if best is None or best[2].count < self.settings.relocation_inliers:
            return Fix(time, False, "lost", len(seen.ground))
        index, matches, found = best
        self.filter.relocate(index, found.pose, found.covariance + np.diag(np.square(self.settings.floor)))
        return self._fix(time, True, "relocated", seen, matches, found, index)

    def _place(
        self, seen: _Seen, keyframe: Keyframe, expected: Pose2 | None, covariance: Array | None
    ) -> tuple[int, GroundPose | None]:
        """Number of matches and the pose in the keyframe's frame."""
        allowed = None
        if expected is not None and covariance is not None:
            position = 3.0 * math.sqrt(float(covariance[0, 0] + covariance[1, 1]))
            radius = self.settings.search + position + 3.0 * math.sqrt(float(covariance[2, 2]))
            here = expected.transform(seen.ground).astype(np.float32)
            there = keyframe.ground.astype(np.float32)
            dx = here[:, 0, None] - there[None, :, 0]
            dy = here[:, 1, None] - there[None, :, 1]
            allowed = dx * dx + dy * dy < np.float32(radius * radius)
        rows, columns = mutual_matches(hamming(seen.signs, keyframe.signs), allowed, self.settings.match)
        kept = dbscan(seen.ground[rows], self.settings.epsilon, self.settings.min_points) != NOISE
        rows, columns = rows[kept], columns[kept]
        # The keyframe's own noise counts in pixels of this frame: far points there are coarse points here.
        ratio = keyframe.pixel_m[columns] / seen.pixel_m[rows]
        noise = np.sqrt(0.5 + 0.5 * ratio * ratio)
        return len(rows), solve_ground_pose(
            keyframe.ground[columns], seen.ground[rows], self.camera, self.settings.ground_pose, noise
        )

    def _keep(self, time: float, seen: _Seen) -> None:
        if len(self.keyframes) >= self.settings.keyframes.limit:
            index = self.keyframes.redundant(self.filter.keyframe_poses())
            self.filter.drop_keyframe(index)
            del self.keyframes.frames[index]
        self.filter.add_keyframe(np.diag(np.square(self.settings.blur)))
        self.keyframes.frames.append(Keyframe(seen.ground, seen.signs, seen.pixel_m, time))

    def _fix(
        self, time: float, accepted: bool, reason: str, seen: _Seen, matches: int, found: GroundPose, index: int
    ) -> Fix:
        pose = self.filter.keyframe_pose(index).compose(found.pose)
        return Fix(
            time,
            accepted,
            reason,
            len(seen.ground),
            matches,
            found.count,
            found.residual_px,
            pose.x,
            pose.y,
            pose.heading,
        )

    def _advance(self, robot: Array, left: float, right: float) -> tuple[Array, Array, Array]:
        return advance(robot, left, right, self.settings.track_width, self.settings.noise)

    def _move_filter(self, time: float) -> None:
        """The filter up to `time` by all wheel reports until then; what none covers adds uncertainty."""
        self._past.append((self._filter_time, self.filter.mean[:3].copy()))
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

    def _step_front(self, left: float, right: float) -> None:
        if left == 0.0 and right == 0.0:
            return
        self._front, step, noise = self._advance(self._front, left, right)
        self._front_covariance = step @ self._front_covariance @ step.T + noise

    def _catch_up(self) -> None:
        """The newest pose from the corrected filter and the wheel reports that came after the frame."""
        self._front = self.filter.mean[:5].copy()
        self._front_covariance = self.filter.robot_covariance
        for travel in self._history.until(math.inf):
            self._step_front(travel.left, travel.right)


def _pose(state: Array) -> Pose2:
    return Pose2(float(state[0]), float(state[1]), wrap_angle(float(state[2])))
