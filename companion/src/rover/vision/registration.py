"""Registering two pictures (section 3.1 of the paper): ORB, matching, DBSCAN, RANSAC homography, equation 6.

It refuses rather than being wrong: a homography counts only if far more matches agree with it than chance would
bring about, if they cover a part of both pictures, if it is one that a camera can produce, and if the pictures agree
where it lays one on the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.cluster import EPSILON_PX, MIN_POINTS, NOISE, dbscan
from rover.vision.features import FeatureDetector, Features, FeatureSettings
from rover.vision.homography import apply_homography
from rover.vision.matching import MatchSettings, match_features
from rover.vision.plausible import astray, impossible, overlap
from rover.vision.preprocess import Preprocessor, PreprocessSettings, local_contrast
from rover.vision.refine import RefineSettings, refine_from_afar
from rover.vision.verify import agreement, disagreeing_share

Points = NDArray[np.float64]
Picture = NDArray[np.uint8] | NDArray[np.uint16]
Cluster = Literal["displacement", "position"]

PAPER_EPSILON = EPSILON_PX / 320.0
"""The paper's ε as a share of its picture's width; it clusters by position."""


@dataclass(frozen=True)
class RegistrationSettings:
    """cluster: DBSCAN on matches by position and displacement, or by position in each picture as in the paper.

    epsilon: of DBSCAN, a share of the picture's width; min_points: its core points.
    inlier_px: how far a match may lie from where the homography puts it.

    min_inliers, min_ratio: fewer agreeing matches, or a smaller share of all clustered ones, is a refusal.
    min_spread: the inliers' bounding box, as a share of each picture's area.
    min_kept: share of the inliers that must still agree after the refinement; with fewer it is not used.
    rival: share of as many matches that may agree with another place: of two windows that look alike, which is it?
    min_overlap: share of A that must lie in B: beyond, the homography is a guess. min_agreement: see `agreement`.
    coarse: of the way by a similarity: how far a match may lie from where it is put, a share of B's width;
    coarse_inliers: matches that must agree so far; coarse_rival: share of as many that may agree with something
    else; coarse_kept: with the refined homography, to `inlier_px`.
    coarse_overlap, coarse_agreement, coarse_apart: what it takes to believe it alone: share that each picture must
    have of the other, agreement, and the share of the picture that may disagree nevertheless.
    better: by how much its agreement must be the higher for it to be preferred.
    contradiction: of `register`: how far A's corners may come back from where they were, the way to B and back, mean,
    a share of A's width.
    """

    preprocess: PreprocessSettings = field(
        default_factory=lambda: PreprocessSettings(fixed_pattern=False, dead_pixels=False, clahe_clip=2.0)
    )
    features: FeatureSettings = field(
        default_factory=lambda: FeatureSettings(
            count=2000, columns=12, rows=9, levels=8, scale=1.2, patch=31, threshold_start=20
        )
    )
    match: MatchSettings = field(default_factory=lambda: MatchSettings(max_distance=72.0, ratio=0.85))
    cluster: Cluster = "displacement"
    epsilon: float = 40.0 / 320.0
    min_points: int = MIN_POINTS
    inlier_px: float = 3.0
    min_inliers: int = 14
    min_ratio: float = 0.28
    min_spread: float = 0.01
    refine: RefineSettings = field(default_factory=RefineSettings)
    min_kept: float = 0.6
    rival: float = 0.5
    min_overlap: float = 0.4
    min_agreement: float = 0.5
    coarse: float = 0.0125
    coarse_inliers: int = 10
    coarse_rival: float = 0.3
    coarse_kept: int = 6
    coarse_overlap: float = 0.5
    coarse_agreement: float = 0.45
    coarse_apart: float = 0.25
    better: float = 0.03
    contradiction: float = 0.05
    seed: int = 1


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


def confirm(
    found: Registration, sharp_a: NDArray[np.uint8], sharp_b: NDArray[np.uint8], settings: RegistrationSettings
) -> Registration:
    """`found` with its homography made exact, or refused where the pictures themselves speak against it.

    Pictures: (H, W) uint8 of `local_contrast`.
    """
    if found.homography is None:
        return found
    found = _refined(found, sharp_a, sharp_b, settings)
    shared = overlap(found.homography, sharp_a.shape, sharp_b.shape)
    if shared < settings.min_overlap:
        return replace(found, status="failed", reason="the pictures overlap too little", homography=None)
    correlation = agreement(sharp_a, sharp_b, found.homography)
    if correlation < settings.min_agreement:
        return replace(found, status="failed", reason="the pictures differ where they overlap", homography=None)
    return replace(found, agreement=correlation)


def _refined(
    found: Registration, sharp_a: NDArray[np.uint8], sharp_b: NDArray[np.uint8], settings: RegistrationSettings
) -> Registration:
    assert found.homography is not None
    homography = refine_from_afar(sharp_a, sharp_b, found.homography, settings.refine)
    apart = np.linalg.norm(apply_homography(homography, found.points_a) - found.points_b, axis=1)
    agree = apart <= settings.inlier_px
    if agree.sum() < settings.min_kept * found.inliers:
        return found
    points_a, points_b = found.points_a[agree], found.points_b[agree]
    return replace(
        found,
        inliers=len(points_a),
        homography=homography,
        rmse_before=rmse(points_a, points_b),
        rmse_after=rmse(apply_homography(homography, points_a), points_b),
        points_a=points_a,
        points_b=points_b,
    )


def register(image_a: Picture, image_b: Picture, settings: RegistrationSettings | None = None) -> Registration:
    """Where picture A lies in picture B. Pictures are (H, W), 8 or 16 bits, not necessarily of equal size.

    Asked both ways: an answer that the way from B to A contradicts is refused, for nobody can say which is right.
    """
    settings = settings or RegistrationSettings()
    a, b = prepare(image_a, settings), prepare(image_b, settings)
    found = register_prepared(a, b, settings)
    back = register_prepared(b, a, settings).homography if found.homography is not None else None
    if found.homography is None or back is None:
        return found
    if astray(found.homography, back, a.sharp.shape) <= settings.contradiction * a.sharp.shape[1]:
        return found
    return replace(found, status="failed", reason="the way back says something else", homography=None)


def register_prepared(a: Prepared, b: Prepared, settings: RegistrationSettings) -> Registration:
    """As `register`, from pictures prepared with the same settings."""
    found = register_features(a.features, b.features, a.sharp.shape, b.sharp.shape, settings)
    found = confirm(found, a.sharp, b.sharp, settings)
    other = _by_similarity(a, b, settings)
    if other is None or other.homography is None:
        return found
    forth = overlap(other.homography, a.sharp.shape, b.sharp.shape)
    if found.homography is not None:
        # Two ways to the same answer; the matches of the first may have left all to a corner of the picture.
        better = forth >= settings.min_overlap and other.agreement > found.agreement + settings.better
        return other if better else found
    back = overlap(np.linalg.inv(other.homography), b.sharp.shape, a.sharp.shape)
    if min(forth, back) < settings.coarse_overlap or other.agreement < settings.coarse_agreement:
        return found
    apart = disagreeing_share(a.sharp, b.sharp, other.homography)
    return other if apart <= settings.coarse_apart else found


def _by_similarity(a: Prepared, b: Prepared, settings: RegistrationSettings) -> Registration | None:
    """A similarity, made exact: parallax, blur or a change of scale leave few matches to a homography of 3 px.

    A similarity needs but two matches and forgives more: it only has to bring the pictures near enough to each other
    for the refinement. None where too few matches agree with it, where nearly as many agree with another (of two
    windows that look alike, which?), or where it is none that a camera can produce.
    """
    in_a, in_b = match_features(a.features, b.features, settings.match)
    points_a, points_b = a.features.points[in_a], b.features.points[in_b]
    if len(points_a) < settings.coarse_inliers:
        return None
    tolerance = max(settings.inlier_px, settings.coarse * b.sharp.shape[1])
    near, agree = _similarity(points_a, points_b, tolerance, settings)
    _, elsewhere = _similarity(points_a[~agree], points_b[~agree], tolerance, settings)
    if near is None or agree.sum() < settings.coarse_inliers or elsewhere.sum() > settings.coarse_rival * agree.sum():
        return None
    homography = refine_from_afar(a.sharp, b.sharp, near, settings.refine)
    apart = np.linalg.norm(apply_homography(homography, points_a) - points_b, axis=1)
    inlier = apart <= settings.inlier_px
    if int(inlier.sum()) < settings.coarse_kept or impossible(homography, a.sharp.shape):
        return None
    points_a, points_b = points_a[inlier], points_b[inlier]
    return Registration(
        "ok",
        "",
        (len(a.features), len(b.features)),
        len(in_a),
        int((apart <= tolerance).sum()),
        len(points_a),
        homography,
        rmse(points_a, points_b),
        rmse(apply_homography(homography, points_a), points_b),
        points_a,
        points_b,
        agreement(a.sharp, b.sharp, homography),
    )


def _has_rival(
    homography: Points, points_a: Points, points_b: Points, shape_b: tuple[int, ...], settings: RegistrationSettings
) -> bool:
    """True where nearly as many matches as fit the homography agree on something else."""
    tolerance = max(settings.inlier_px, settings.coarse * shape_b[1])
    fits = np.linalg.norm(apply_homography(homography, points_a) - points_b, axis=1) <= tolerance
    _, elsewhere = _similarity(points_a[~fits], points_b[~fits], tolerance, settings)
    return bool(elsewhere.sum() > settings.rival * fits.sum())


def _similarity(
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
        return None, np.zeros(len(points_a), bool)
    return np.vstack((found, (0.0, 0.0, 1.0))), agree.ravel() > 0


def register_features(
    a: Features,
    b: Features,
    shape_a: tuple[int, ...],
    shape_b: tuple[int, ...],
    settings: RegistrationSettings,
) -> Registration:
    """As `register`, from features found before; shapes are (H, W)."""
    found = (len(a), len(b))
    in_a, in_b = match_features(a, b, settings.match)
    matches = len(in_a)
    matched_a, matched_b = a.points[in_a], b.points[in_b]
    grouped = clustered_matches(matched_a / shape_a[1], matched_b / shape_b[1], settings)
    points_a, points_b = matched_a[grouped], matched_b[grouped]
    clustered = len(points_a)
    if clustered < settings.min_inliers:
        return Registration("failed", "too few matches", found, matches, clustered)
    cv2.setRNGSeed(settings.seed)
    homography, _ = cv2.findHomography(
        points_a, points_b, cv2.USAC_MAGSAC, settings.inlier_px, maxIters=5000, confidence=0.999
    )
    if homography is None:
        return Registration("failed", "no homography agrees with the matches", found, matches, clustered)
    inlier = np.linalg.norm(apply_homography(homography, points_a) - points_b, axis=1) <= settings.inlier_px
    count = int(inlier.sum())
    reason = _objection(homography, points_a[inlier], points_b[inlier], clustered, shape_a, shape_b, settings)
    if not reason and _has_rival(homography, matched_a, matched_b, shape_b, settings):
        reason = "another place fits nearly as well"
    if reason:
        return Registration("failed", reason, found, matches, clustered, count)
    points_a, points_b = points_a[inlier], points_b[inlier]
    return Registration(
        "ok",
        "",
        found,
        matches,
        clustered,
        count,
        homography,
        rmse(points_a, points_b),
        rmse(apply_homography(homography, points_a), points_b),
        points_a,
        points_b,
    )


def clustered_matches(a: Points, b: Points, settings: RegistrationSettings) -> NDArray[np.bool_]:
    """Which matched points (N, 2) DBSCAN does not call noise, (N,); points and epsilon in widths of their pictures."""
    if settings.cluster == "displacement":
        return dbscan(np.column_stack((a, b - a)), settings.epsilon, settings.min_points) != NOISE
    apart = (dbscan(points, settings.epsilon, settings.min_points) != NOISE for points in (a, b))
    return np.logical_and(*apart)


def _objection(
    homography: Points,
    points_a: Points,
    points_b: Points,
    clustered: int,
    shape_a: tuple[int, ...],
    shape_b: tuple[int, ...],
    settings: RegistrationSettings,
) -> str:
    """Why this homography must not be believed; empty when nothing speaks against it."""
    if len(points_a) < settings.min_inliers or len(points_a) < settings.min_ratio * clustered:
        return "too few matches agree"
    for points, shape in ((points_a, shape_a), (points_b, shape_b)):
        extent = points.max(axis=0) - points.min(axis=0)
        if extent[0] * extent[1] < settings.min_spread * shape[0] * shape[1]:
            return "the agreeing matches cover too little of the picture"
    return impossible(homography, shape_a)
