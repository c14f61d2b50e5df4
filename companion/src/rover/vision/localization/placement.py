"""Where a frame was taken, seen from a keyframe: matching, DBSCAN, PnP on the ground plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.vision.camera.model import CameraModel
from rover.vision.localization.ground_pose import GroundPose, GroundPoseSettings, solve_ground_pose
from rover.vision.localization.keyframes import Keyframe
from rover.vision.localization.observation import Mark, Observation, no_mark
from rover.vision.registration.cluster import NOISE, dbscan
from rover.vision.registration.matching import MatchSettings, hamming, mutual_matches

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlacementSettings:
    """search: metres around its expected place in which a feature is looked for, beyond three sigma.

    epsilon, min_points: of DBSCAN, metres on the ground.
    """

    search: float = 0.04
    epsilon: float = 0.16
    min_points: int = 5
    match: MatchSettings = field(default_factory=MatchSettings)
    ground_pose: GroundPoseSettings = field(default_factory=GroundPoseSettings)


@dataclass(frozen=True, eq=False)
class Placement:
    """matches: with the keyframe, before DBSCAN. found: base_link in the keyframe's frame, None without consensus.

    extent: standard deviation in metres of the inliers along the direction in which they spread least.
    """

    matches: int
    found: GroundPose | None = None
    extent: float = 0.0


def search_area(expected: Pose2, covariance: Array, settings: PlacementSettings) -> tuple[Pose2, float]:
    """Where features are looked for: the expected pose in the keyframe's frame and a radius in metres."""
    position = 3.0 * math.sqrt(float(covariance[0, 0] + covariance[1, 1]))
    # Features lie about a metre ahead: a radian of heading moves them by that.
    return expected, settings.search + position + 3.0 * math.sqrt(float(covariance[2, 2]))


def place(
    seen: Observation,
    keyframe: Keyframe,
    camera: CameraModel,
    area: tuple[Pose2, float] | None,
    settings: PlacementSettings,
    mark: Mark = no_mark,
) -> Placement:
    """The pose from which `keyframe`'s ground looks as it was seen; area: as from `search_area`, None for anywhere."""
    rows, columns = _matches(seen, keyframe, area, settings)
    mark("match")
    matches = len(rows)
    kept = dbscan(seen.ground[rows], settings.epsilon, settings.min_points) != NOISE
    rows, columns = rows[kept], columns[kept]
    mark("cluster")
    # The keyframe's own noise counts in pixels of this frame: far points there are coarse points here.
    ratio = keyframe.pixel_m[columns] / seen.pixel_m[rows]
    noise = np.sqrt(0.5 + 0.5 * ratio * ratio)
    found = solve_ground_pose(keyframe.ground[columns], seen.ground[rows], camera, settings.ground_pose, noise)
    extent = 0.0 if found is None else least_extent(seen.ground[rows][found.inliers])
    mark("pose")
    return Placement(matches, found, extent)


def _matches(
    seen: Observation, keyframe: Keyframe, area: tuple[Pose2, float] | None, settings: PlacementSettings
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices into both of the features that match; only features with any partner in reach are compared."""
    if area is None:
        return mutual_matches(hamming(seen.descriptors, keyframe.descriptors), None, settings.match)
    near = _near(area, seen.ground, keyframe.ground)
    mine, theirs = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    distances = hamming(seen.descriptors[mine], keyframe.descriptors[theirs])
    rows, columns = mutual_matches(distances, near[np.ix_(mine, theirs)], settings.match)
    return mine[rows], theirs[columns]


def least_extent(points: Array) -> float:
    """Standard deviation of points (N, 2) along the direction in which they spread least."""
    (a, b), (_, d) = np.cov(points.T, bias=True).tolist()
    return math.sqrt(max(0.0, 0.5 * (a + d) - math.hypot(0.5 * (a - d), b)))


def _near(area: tuple[Pose2, float], seen: Array, known: Array) -> NDArray[np.bool_]:
    pose, radius = area
    here = pose.transform(seen).astype(np.float32)
    there = known.astype(np.float32)
    dx = here[:, 0, None] - there[None, :, 0]
    dy = here[:, 1, None] - there[None, :, 1]
    near: NDArray[np.bool_] = dx * dx + dy * dy < np.float32(radius * radius)
    return near
