"""The rover's pose: wheels between frames, frames against keyframes, refused when they can't be trusted.

    clean → lay on the ground → ORB → match with keyframes → DBSCAN → PnP → gate → correct
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2, wrap_angle
from rover.vision.camera import CameraModel
from rover.vision.cluster import NOISE, dbscan
from rover.vision.features import FeatureDetector, Features, FeatureSettings
from rover.vision.ground_view import GroundView
from rover.vision.keyframe_chain import Keyframe, Keyframes, KeyframeSettings
from rover.vision.matching import MatchSettings, hamming, mutual_matches, signs
from rover.vision.planar_pose import GroundPose, GroundPoseSettings, solve_ground_pose
from rover.vision.preprocess import Preprocessor, PreprocessSettings
from rover.vision.wheel_filter import FilterSettings, WheelFilter


@dataclass(frozen=True)
class LocalizerSettings:
    """search: metres around its expected place in which a feature is looked for, beyond three sigma.

    gate: squared Mahalanobis distance up to which a pose is believed (99.9 % of three degrees of freedom).
    floor: 1σ of x, y (m) and heading (rad) that no single frame is better than. hop: what a keyframe's own pose
    adds, for frames placed by the same keyframe share its errors. lost_after: refused frames in a row.
    enough: matches that agree, at which no further keyframe is asked.
    epsilon: of DBSCAN, metres on the ground.
    """

    search: float = 0.05
    gate: float = 16.3
    floor: tuple[float, float, float] = (0.004, 0.004, 0.004)
    hop: tuple[float, float, float] = (0.004, 0.004, 0.005)
    lost_after: int = 12
    enough: int = 25
    epsilon: float = 0.16
    min_points: int = 5
    preprocess: PreprocessSettings = field(default_factory=PreprocessSettings)
    features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=220))
    match: MatchSettings = field(default_factory=MatchSettings)
    ground_pose: GroundPoseSettings = field(default_factory=GroundPoseSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    filter: FilterSettings = field(default_factory=FilterSettings)


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
    ) -> None:
        self.settings = settings or LocalizerSettings()
        self.camera = camera
        self.filter = WheelFilter(start, start_sigma, self.settings.filter)
        self.keyframes = Keyframes(self.settings.keyframes)
        self.odometry_only = start
        self._view = GroundView(camera)
        self._preprocess = Preprocessor(self.settings.preprocess)
        self._detector = FeatureDetector(self.settings.features)
        self._refused = 0

    @property
    def pose(self) -> Pose2:
        """The newest pose in map."""
        return self.filter.pose

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) of x, y, heading."""
        return self.filter.covariance[:3, :3]

    def pose_at(self, time: float) -> Pose2:
        """The pose at a time of the last half second."""
        mean, _ = self.filter.at(time)
        return Pose2(float(mean[0]), float(mean[1]), wrap_angle(float(mean[2])))

    def predict(self, time: float, left: float, right: float) -> None:
        """Wheel travel in metres that ends at `time`."""
        self.filter.predict(time, left, right)
        turn = (right - left) / self.settings.filter.track_width
        middle = self.odometry_only.heading + 0.5 * turn
        d = 0.5 * (left + right)
        here = self.odometry_only
        self.odometry_only = Pose2(
            here.x + d * math.cos(middle), here.y + d * math.sin(middle), wrap_angle(here.heading + turn)
        )

    def observe(self, frame: Frame) -> Fix:
        """Takes one frame, exposed at `frame.time`. What is refused leaves the pose to the wheels."""
        if frame.ffc:
            return Fix(frame.time, False, "shutter closed")
        picture = self._preprocess.to_8_bit(self._view.look(self._preprocess.clean(frame.counts)))
        features = self._detector.detect(picture, self._view.mask)
        base = self._view.to_base(features.points)
        if len(features) < self.settings.ground_pose.min_inliers:
            return self._refuse(Fix(frame.time, False, "too little texture", len(features)))
        own = signs(features.descriptors)
        mean, covariance = self.filter.at(frame.time)
        predicted = Pose2(float(mean[0]), float(mean[1]), float(mean[2]))
        if len(self.keyframes) == 0:
            self._keep(predicted, covariance[:3, :3], own, base)
            return Fix(frame.time, True, "first", len(features), keyframe=True)
        lost = self._refused >= self.settings.lost_after
        if not lost and not self.keyframes.overlapping(predicted):
            self._keep(predicted, covariance[:3, :3], own, base)
            fix = Fix(frame.time, False, "new ground: placed by the wheels", len(features), keyframe=True)
            return self._refuse(fix)
        candidates = list(self.keyframes) if lost else self.keyframes.overlapping(predicted)
        best: tuple[GroundPose, Keyframe, int] | None = None
        reason = "no keyframe shows this ground"
        for keyframe in candidates:
            matched = self._match(own, base, keyframe, predicted, covariance, lost)
            found = self._place(features, base, keyframe, matched, predicted)
            if isinstance(found, str):
                reason = found
                continue
            if best is None or found.inliers.sum() > best[0].inliers.sum():
                best = (found, keyframe, len(matched[0]))
            if not lost and found.inliers.sum() >= self.settings.enough:
                break  # the keyframe placed first is good enough
        if best is None:
            return self._refuse(Fix(frame.time, False, reason, len(features)))
        return self._take(frame, best, own, base, len(features), lost)

    def _match(
        self,
        own: NDArray[np.float32],
        base: NDArray[np.float64],
        keyframe: Keyframe,
        predicted: Pose2,
        covariance: NDArray[np.float64],
        lost: bool,
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Features that look alike and, unless the rover is lost, lie where they are expected."""
        allowed = None
        if not lost:
            position = 3.0 * math.sqrt(float(np.trace(covariance[:2, :2])))
            heading = 3.0 * math.sqrt(float(covariance[2, 2]))
            radius = self.settings.search + position + heading * 1.0
            expected = predicted.transform(base).astype(np.float32)
            there = keyframe.points.astype(np.float32)
            dx = expected[:, 0, None] - there[None, :, 0]
            dy = expected[:, 1, None] - there[None, :, 1]
            allowed = dx * dx + dy * dy < np.float32(radius**2)
        return mutual_matches(hamming(own, keyframe.signs), allowed, self.settings.match)

    def _place(
        self,
        features: Features,
        base: NDArray[np.float64],
        keyframe: Keyframe,
        matched: tuple[NDArray[np.intp], NDArray[np.intp]],
        predicted: Pose2,
    ) -> GroundPose | str:
        rows, columns = matched
        grouped = dbscan(base[rows], self.settings.epsilon, self.settings.min_points) != NOISE
        rows, columns = rows[grouped], columns[grouped]
        pixels = self.camera.ground_to_pixel(base[rows])
        return solve_ground_pose(self.camera, keyframe.points[columns], pixels, predicted, self.settings.ground_pose)

    def _take(
        self,
        frame: Frame,
        best: tuple[GroundPose, Keyframe, int],
        own: NDArray[np.float32],
        base: NDArray[np.float64],
        keypoints: int,
        lost: bool,
    ) -> Fix:
        found, keyframe, matches = best
        noise = found.covariance + np.diag(np.square(self.settings.floor))
        fix = Fix(
            frame.time,
            True,
            "",
            keypoints,
            matches,
            int(found.inliers.sum()),
            found.residual_px,
            found.pose.x,
            found.pose.y,
            found.pose.heading,
        )
        if lost:
            self.filter.loosen((0.5, 0.5, 1.0))
        elif self.filter.mahalanobis(frame.time, found.pose, noise + keyframe.covariance) > self.settings.gate:
            return self._refuse(_refused(fix, "contradicts the wheels"))
        self.filter.correct(frame.time, found.pose, noise, keyframe.covariance)
        self._refused = 0
        mean, covariance = self.filter.at(frame.time)
        pose = Pose2(float(mean[0]), float(mean[1]), float(mean[2]))
        if self.keyframes.is_new(pose) and not lost:
            self._keep(pose, covariance[:3, :3], own, base)
        return fix

    def _keep(
        self, pose: Pose2, covariance: NDArray[np.float64], own: NDArray[np.float32], base: NDArray[np.float64]
    ) -> None:
        if len(self.keyframes):
            covariance = covariance + np.diag(np.square(self.settings.hop))
        self.keyframes.add(pose, covariance.copy(), own, pose.transform(base))

    def _refuse(self, fix: Fix) -> Fix:
        """Counts a frame that did not correct the pose."""
        self._refused += 1
        return fix


def _refused(fix: Fix, reason: str) -> Fix:
    return Fix(
        fix.time, False, reason, fix.keypoints, fix.matches, fix.inliers, fix.residual_px, fix.x, fix.y, fix.heading
    )
