"""Registering two pictures (section 3.1 of the paper): ORB, matching, DBSCAN, RANSAC homography, equation 6.

It refuses rather than being wrong: a homography counts only if far more matches agree with it than chance would
bring about, if they cover a part of both pictures, if it is one that a camera can produce, if the pictures agree
where it lays one on the other, and if the way back does not contradict it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.correspondence import Correspondence, correspond, correspond_both_ways
from rover.vision.registration.features import FeatureDetector, Features
from rover.vision.registration.hypothesis import (
    Registration,
    distances,
    forgiving_px,
    judged,
    refused,
    rmse,
    similarity,
    supported,
)
from rover.vision.registration.plausible import astray, impossible, overlap
from rover.vision.registration.preprocess import Preprocessor, local_contrast
from rover.vision.registration.refine import refine_from_afar
from rover.vision.registration.settings import PAPER_EPSILON, RegistrationSettings
from rover.vision.registration.verify import agreement, disagreeing_share

__all__ = [
    "PAPER_EPSILON",
    "Picture",
    "Prepared",
    "Registration",
    "RegistrationSettings",
    "find_features",
    "prepare",
    "register",
    "register_features",
    "register_prepared",
    "rmse",
]

Picture = NDArray[np.uint8] | NDArray[np.uint16]
ESTIMATORS = {"magsac": cv2.USAC_MAGSAC, "ransac": cv2.RANSAC}


@dataclass(frozen=True, eq=False)
class Prepared:
    """What registration works out of one picture, once for all its pairs.

    features: of the preprocessed picture. sharp: (H, W) uint8, its `local_contrast`.
    """

    features: Features
    sharp: NDArray[np.uint8]


def prepare(picture: Picture, settings: RegistrationSettings) -> Prepared:
    """One picture (H, W) of 8 or 16 bits, ready for `register_prepared`."""
    return Prepared(find_features(picture, settings), local_contrast(picture))


def find_features(picture: Picture, settings: RegistrationSettings) -> Features:
    """The features of one picture (H, W) of 8 or 16 bits."""
    prepared = Preprocessor(settings.preprocess)(picture)
    return FeatureDetector(settings.features).detect(prepared)


def register(image_a: Picture, image_b: Picture, settings: RegistrationSettings | None = None) -> Registration:
    """Where picture A lies in picture B. Pictures are (H, W), 8 or 16 bits, not necessarily of equal size."""
    settings = settings or RegistrationSettings()
    return register_prepared(prepare(image_a, settings), prepare(image_b, settings), settings)


def register_prepared(a: Prepared, b: Prepared, settings: RegistrationSettings) -> Registration:
    """As `register`, from pictures prepared with the same settings.

    Asked both ways: an answer that the way from B to A contradicts is refused, for nobody can say which is right.
    """
    there, back = correspond_both_ways(a.features, b.features, a.sharp.shape, b.sharp.shape, settings)
    found = _one_way(a, b, there, settings)
    returned = _one_way(b, a, back, settings).homography if found.homography is not None else None
    if found.homography is None or returned is None:
        return found
    if astray(found.homography, returned, a.sharp.shape) <= settings.contradiction * a.sharp.shape[1]:
        return found
    return replace(found, status="failed", reason="the way back says something else", homography=None)


def register_features(
    a: Features, b: Features, shape_a: tuple[int, ...], shape_b: tuple[int, ...], settings: RegistrationSettings
) -> Registration:
    """One way and by the matches alone, from features found before; shapes are (H, W)."""
    return _by_matches(correspond(a, b, shape_a, shape_b, settings), settings)


def _one_way(a: Prepared, b: Prepared, matched: Correspondence, settings: RegistrationSettings) -> Registration:
    """The better of two ways to a homography from A to B; the pictures have agreed to it."""
    found = _shown(_refined(_by_matches(matched, settings), a, b, matched, settings), a, b, settings)
    other = _by_similarity(a, b, matched, settings)
    if other is None or other.homography is None:
        return found
    forth = overlap(other.homography, a.sharp.shape, b.sharp.shape)
    if found.homography is not None:
        # Two ways to the same answer; the matches of the first may have left all to a corner of the picture.
        better = forth >= settings.min_overlap and other.agreement > found.agreement + settings.better
        return other if better else found
    inverse = np.asarray(np.linalg.inv(other.homography), np.float64)
    back = overlap(inverse, b.sharp.shape, a.sharp.shape)
    if min(forth, back) < settings.coarse_overlap or other.agreement < settings.coarse_agreement:
        return found
    apart = disagreeing_share(a.sharp, b.sharp, other.homography)
    return other if apart <= settings.coarse_apart else found


def _by_matches(matched: Correspondence, settings: RegistrationSettings) -> Registration:
    """The homography that most clustered matches agree with."""
    if len(matched.clustered_a) < settings.min_inliers:
        return refused("too few matches", matched)
    cv2.setRNGSeed(settings.seed)
    homography, _ = cv2.findHomography(
        matched.clustered_a,
        matched.clustered_b,
        ESTIMATORS[settings.estimator],
        settings.inlier_px,
        maxIters=5000,
        confidence=0.999,
    )
    if homography is None:
        # The stub does not know that there may be none.
        return refused("no homography agrees with the matches", matched)  # type: ignore[unreachable]
    return judged(np.asarray(homography, np.float64), matched, settings)


def _refined(
    found: Registration, a: Prepared, b: Prepared, matched: Correspondence, settings: RegistrationSettings
) -> Registration:
    """`found` with its homography made exact.

    All clustered matches are asked again: those that were off by a little agree with the exact one, and where a bush
    before a wall had most of the matches, the wall has most of the picture.
    """
    if found.homography is None:
        return found
    exact = supported(refine_from_afar(a.sharp, b.sharp, found.homography, settings.refine), matched, settings)
    return exact if exact.inliers >= settings.min_kept * found.inliers else found


def _shown(found: Registration, a: Prepared, b: Prepared, settings: RegistrationSettings) -> Registration:
    """`found`, refused where the pictures themselves speak against it."""
    if found.homography is None:
        return found
    if overlap(found.homography, a.sharp.shape, b.sharp.shape) < settings.min_overlap:
        return replace(found, status="failed", reason="the pictures overlap too little", homography=None)
    correlation = agreement(a.sharp, b.sharp, found.homography)
    if correlation < settings.min_agreement:
        return replace(found, status="failed", reason="the pictures differ where they overlap", homography=None)
    return replace(found, agreement=correlation)


def _by_similarity(
    a: Prepared, b: Prepared, matched: Correspondence, settings: RegistrationSettings
) -> Registration | None:
    """A similarity, made exact: parallax, blur or a change of scale leave few matches to a homography of 3 px.

    A similarity needs but two matches and forgives more: it only has to bring the pictures near enough to each other
    for the refinement. None where too few matches agree with it, where nearly as many agree with another (of two
    windows that look alike, which?), or where it is none that a camera can produce.
    """
    points_a, points_b = matched.all_a, matched.all_b
    if len(points_a) < settings.coarse_inliers:
        return None
    tolerance = forgiving_px(matched.shape_b, settings)
    near, agree = similarity(points_a, points_b, tolerance, settings)
    _, elsewhere = similarity(points_a[~agree], points_b[~agree], tolerance, settings)
    if near is None or agree.sum() < settings.coarse_inliers or elsewhere.sum() > settings.coarse_rival * agree.sum():
        return None
    homography = refine_from_afar(a.sharp, b.sharp, near, settings.refine)
    apart = distances(homography, points_a, points_b)
    close = apart <= tolerance
    if int((apart <= settings.inlier_px).sum()) < settings.coarse_kept or impossible(homography, matched.shape_a):
        return None
    forgiven = replace(matched, clustered_a=points_a[close], clustered_b=points_b[close])
    return replace(supported(homography, forgiven, settings), agreement=agreement(a.sharp, b.sharp, homography))
