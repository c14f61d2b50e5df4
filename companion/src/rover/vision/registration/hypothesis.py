"""A homography that may be the right one: which matches speak for it, and what speaks against it."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.correspondence import Correspondence, Points
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.plausible import impossible
from rover.vision.registration.settings import RegistrationSettings


@dataclass(frozen=True, eq=False)
class Registration:
    """status: "ok" or "failed"; reason: why it failed. homography: (3, 3) from picture A to B, None when failed.

    keypoints: found in A and in B. clustered: matches left after DBSCAN. rmse_*_px: equation 6 on the inliers.
    points_a, points_b: the inliers, (N, 2) pixels. agreement: correlation of the pictures where both show the plane.
    """

    status: str
    reason: str
    keypoints: tuple[int, int]
    matches: int = 0
    clustered: int = 0
    inliers: int = 0
    homography: Points | None = None
    rmse_before: float | None = None
    rmse_after: float | None = None
    points_a: Points = field(default_factory=lambda: np.empty((0, 2)))
    points_b: Points = field(default_factory=lambda: np.empty((0, 2)))
    agreement: float = 0.0


def rmse(a: Points, b: Points) -> float:
    """Root mean square distance of matched points (N, 2) (eq. 6)."""
    return float(np.sqrt(np.mean(np.sum((a - b) ** 2, axis=1))))


def refused(reason: str, matched: Correspondence, inliers: int = 0) -> Registration:
    """A registration that failed."""
    return Registration("failed", reason, matched.keypoints, len(matched.all_a), len(matched.clustered_a), inliers)


def supported(homography: Points, matched: Correspondence, settings: RegistrationSettings) -> Registration:
    """The homography with the clustered matches that agree with it, whatever speaks against it."""
    inlier = distances(homography, matched.clustered_a, matched.clustered_b) <= settings.inlier_px
    points_a, points_b = matched.clustered_a[inlier], matched.clustered_b[inlier]
    return Registration(
        "ok",
        "",
        matched.keypoints,
        len(matched.all_a),
        len(matched.clustered_a),
        len(points_a),
        homography,
        rmse(points_a, points_b) if len(points_a) else None,
        rmse(apply_homography(homography, points_a), points_b) if len(points_a) else None,
        points_a,
        points_b,
    )


def judged(homography: Points, matched: Correspondence, settings: RegistrationSettings) -> Registration:
    """As `supported`, refused where the matches or what a camera can produce speak against it."""
    found = supported(homography, matched, settings)
    reason = _objection(found, matched, settings)
    return refused(reason, matched, found.inliers) if reason else found


def distances(homography: Points, points_a: Points, points_b: Points) -> NDArray[np.float64]:
    """How far the matched points (N, 2) of B lie from where the homography puts those of A, (N,) pixels."""
    return np.asarray(np.linalg.norm(apply_homography(homography, points_a) - points_b, axis=1))


def similarity(
    points_a: Points, points_b: Points, tolerance: float, settings: RegistrationSettings
) -> tuple[Points | None, NDArray[np.bool_]]:
    """The similarity (3, 3) that most matched points (N, 2) agree with to `tolerance` pixels, and which do, (N,)."""
    if len(points_a) < 3:
        return None, np.zeros(len(points_a), bool)
    cv2.setRNGSeed(settings.seed)
    found, agree = cv2.estimateAffinePartial2D(
        points_a, points_b, method=cv2.RANSAC, ransacReprojThreshold=tolerance, maxIters=3000, confidence=0.999
    )
    if found is None:
        # The stub does not know that there may be none.
        return None, np.zeros(len(points_a), bool)  # type: ignore[unreachable]
    return np.vstack((found, (0.0, 0.0, 1.0))), agree.ravel() > 0


def forgiving_px(shape_b: tuple[int, ...], settings: RegistrationSettings) -> float:
    """How far a match may lie from where a similarity puts it."""
    return max(settings.inlier_px, settings.coarse * shape_b[1])


def _objection(found: Registration, matched: Correspondence, settings: RegistrationSettings) -> str:
    """Why this homography must not be believed; empty when nothing speaks against it."""
    assert found.homography is not None
    if found.inliers < settings.min_inliers or found.inliers < settings.min_ratio * found.clustered:
        return "too few matches agree"
    for points, shape in ((found.points_a, matched.shape_a), (found.points_b, matched.shape_b)):
        extent = points.max(axis=0) - points.min(axis=0)
        if extent[0] * extent[1] < settings.min_spread * shape[0] * shape[1]:
            return "the agreeing matches cover too little of the picture"
    reason = impossible(found.homography, matched.shape_a)
    return reason or ("another place fits nearly as well" if _has_rival(found.homography, matched, settings) else "")


def _has_rival(homography: Points, matched: Correspondence, settings: RegistrationSettings) -> bool:
    """True where nearly as many matches as fit the homography agree on something else."""
    tolerance = forgiving_px(matched.shape_b, settings)
    fits = distances(homography, matched.all_a, matched.all_b) <= tolerance
    _, elsewhere = similarity(matched.all_a[~fits], matched.all_b[~fits], tolerance, settings)
    return bool(elsewhere.sum() > settings.rival * fits.sum())
