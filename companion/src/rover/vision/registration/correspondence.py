"""Which features of two pictures belong together (sections 3.1.3 and 3.1.4 of the paper): matches, and those of them
that stand in clusters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.cluster import NOISE, dbscan
from rover.vision.registration.features import Features
from rover.vision.registration.matching import MatchSettings, match_both_ways, match_features
from rover.vision.registration.settings import RegistrationSettings

Points = NDArray[np.float64]
Shape = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Matched points (N, 2), pixels of each picture: all of them, and the clustered ones.

    keypoints: found in A and in B. shape_a, shape_b: (H, W).
    """

    keypoints: tuple[int, int]
    shape_a: Shape
    shape_b: Shape
    all_a: Points
    all_b: Points
    clustered_a: Points
    clustered_b: Points


def correspond(
    a: Features, b: Features, shape_a: Shape, shape_b: Shape, settings: RegistrationSettings
) -> Correspondence:
    """From A to B."""
    in_a, in_b = match_features(a, b, settings.match)
    return _clustered(len(a), len(b), shape_a, shape_b, a.points[in_a], b.points[in_b], settings)


def correspond_by(
    apart: NDArray[np.float32],
    points_a: Points,
    points_b: Points,
    shape_a: Shape,
    shape_b: Shape,
    match: MatchSettings,
    settings: RegistrationSettings,
) -> tuple[Correspondence, Correspondence]:
    """From A to B and from B to A, from the distances (N, M) of their descriptors.

    Each way has its own runners-up, so that they are not each other's mirror image.
    """
    (there_a, there_b), (back_b, back_a) = match_both_ways(apart, match)
    count = len(points_a), len(points_b)
    return (
        _clustered(*count, shape_a, shape_b, points_a[there_a], points_b[there_b], settings),
        _clustered(*count[::-1], shape_b, shape_a, points_b[back_b], points_a[back_a], settings),
    )


def _clustered(
    found_a: int, found_b: int, shape_a: Shape, shape_b: Shape, a: Points, b: Points, settings: RegistrationSettings
) -> Correspondence:
    grouped = clustered_matches(a / shape_a[1], b / shape_b[1], settings)
    return Correspondence((found_a, found_b), shape_a, shape_b, a, b, a[grouped], b[grouped])


def clustered_matches(a: Points, b: Points, settings: RegistrationSettings) -> NDArray[np.bool_]:
    """Which matched points (N, 2) DBSCAN does not call noise, (N,); points and epsilon in widths of their pictures."""
    if settings.cluster == "none":
        return np.ones(len(a), bool)
    if settings.cluster == "displacement":
        return _grouped(np.column_stack((a, b - a)), settings)
    return _grouped(a, settings) & _grouped(b, settings)


def _grouped(points: Points, settings: RegistrationSettings) -> NDArray[np.bool_]:
    return np.asarray(dbscan(points, settings.epsilon, settings.min_points) != NOISE)
