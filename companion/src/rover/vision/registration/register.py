"""Where one picture lies in another: a homography between two pictures of a plane, or a refusal with its reason.

    ORB features → matches → DBSCAN → USAC_MAGSAC or a similarity → refinement by optical flow → verification

Where ORB's corners do not lead to an answer that the pictures agree to, SIFT's blobs are asked in the same way.
A homography is believed only if enough matches agree with it, over enough of the picture, if it is one that a camera
can produce, if the pictures agree where it lays one on the other, and if the way back does not contradict it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from rover.vision.registration.blobs import blob_distances
from rover.vision.registration.correspondence import Correspondence, correspond, correspond_by
from rover.vision.registration.features import Features
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
from rover.vision.registration.matching import MatchSettings, hamming
from rover.vision.registration.one_scale import Beside, beside, zoom_of
from rover.vision.registration.plausible import astray, impossible, overlap
from rover.vision.registration.prepared import Picture, Points, Prepared, find_features, prepare
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
    "register_near",
    "register_prepared",
    "registered_by",
    "rmse",
]

ESTIMATORS = {"magsac": cv2.USAC_MAGSAC, "ransac": cv2.RANSAC}
# In which sizes of the pictures a guess is made better (halvings), before it is made exact.
COARSE = (2,)


@dataclass(frozen=True, eq=False)
class _Guess:
    """A homography that was made better in small pictures; agreement: of the pictures by it."""

    homography: Points
    shown: Beside
    agreement: float
    by_similarity: bool


def register(image_a: Picture, image_b: Picture, settings: RegistrationSettings | None = None) -> Registration:
    """Where picture A lies in picture B. Pictures are (H, W), 8 or 16 bits, not necessarily of equal size."""
    settings = settings or RegistrationSettings()
    return register_prepared(prepare(image_a, settings), prepare(image_b, settings), settings)


def register_prepared(a: Prepared, b: Prepared, settings: RegistrationSettings) -> Registration:
    """As `register`, from pictures prepared with the same settings."""
    found = registered_by(a, b, *_by_corners(a, b, settings), settings)
    if found.homography is not None or not settings.use_blobs:
        return found
    sparse = replace(settings, min_inliers=settings.blobs.min_inliers, cluster="none")
    other = registered_by(a, b, *_by_blobs(a, b, sparse), sparse)
    return other if other.homography is not None else found


def register_near(a: Prepared, b: Prepared, guess: Points, settings: RegistrationSettings) -> Points | None:
    """The homography (3, 3) from A to B near a guess (3, 3) from elsewhere, as from a chain of other pairs.

    None where the pictures do not agree to it. Costs a third of a registration: nothing is matched.
    """
    if impossible(guess, a.shape):
        return None
    shown = beside(a, b, guess, settings.one_scale)
    inward = refine_from_afar(shown.a, shown.b, shown.inward(guess), settings.refine, COARSE + settings.fine)
    homography = shown.outward(inward)
    if impossible(homography, a.shape) or not _shares_enough(homography, a, b, settings):
        return None
    if agreement(shown.a, shown.b, inward, 1) < settings.min_agreement:
        return None
    return homography if disagreeing_share(shown.a, shown.b, inward, 1) <= settings.coarse_apart else None


def register_features(
    a: Features, b: Features, shape_a: tuple[int, ...], shape_b: tuple[int, ...], settings: RegistrationSettings
) -> Registration:
    """One way and by the matches alone, from features found before; shapes are (H, W)."""
    return _by_matches(correspond(a, b, shape_a, shape_b, settings), settings)


def _by_corners(a: Prepared, b: Prepared, settings: RegistrationSettings) -> tuple[Correspondence, Correspondence]:
    apart = hamming(a.features.descriptors, b.features.descriptors)
    return correspond_by(apart, a.features.points, b.features.points, a.shape, b.shape, settings.match, settings)


def _by_blobs(a: Prepared, b: Prepared, settings: RegistrationSettings) -> tuple[Correspondence, Correspondence]:
    match = MatchSettings(max_distance=1.0, ratio=settings.blobs.ratio)
    apart = blob_distances(a.blobs, b.blobs)
    return correspond_by(apart, a.blobs.points, b.blobs.points, a.shape, b.shape, match, settings)


def registered_by(
    a: Prepared, b: Prepared, there: Correspondence, back: Correspondence, settings: RegistrationSettings
) -> Registration:
    """Asked both ways: an answer that the way from B to A contradicts is refused, for nobody can say which is right."""
    found = _one_way(a, b, there, settings)
    if found.homography is None:
        return found
    returned = _guessed(b, a, back, settings)
    if (
        returned is None
        or astray(found.homography, returned.homography, a.shape) <= settings.contradiction * a.shape[1]
    ):
        return found
    return replace(found, status="failed", reason="the way back says something else", homography=None)


def _one_way(a: Prepared, b: Prepared, matched: Correspondence, settings: RegistrationSettings) -> Registration:
    """The better of two ways to a homography from A to B, made exact; the pictures have agreed to it."""
    found = _by_matches(matched, settings)
    guesses = []
    if found.homography is not None:
        guesses.append(_better(found.homography, a, b, settings, False))
    near = _by_similarity(matched, settings)
    if near is not None:
        guesses.append(_better(near, a, b, settings, True))
    if not guesses:
        return found
    guesses.sort(key=lambda guess: guess.agreement + (0.0 if guess.by_similarity else settings.better), reverse=True)
    refusal = found
    for guess in guesses:
        accept = _accepted_similarity if guess.by_similarity and found.homography is None else _accepted
        tried = accept(guess, found, matched, a, b, settings)
        if tried.homography is not None:
            return tried
        refusal = tried
    return refusal


def _better(
    homography: Points, a: Prepared, b: Prepared, settings: RegistrationSettings, by_similarity: bool
) -> _Guess:
    shown = beside(a, b, homography, settings.one_scale)
    inward = refine_from_afar(shown.a, shown.b, shown.inward(homography), settings.refine, COARSE)
    return _Guess(shown.outward(inward), shown, agreement(shown.a, shown.b, inward, 1), by_similarity)


def _exact(guess: _Guess, settings: RegistrationSettings) -> tuple[Points, float]:
    """The guess made exact in the full pictures, and their agreement."""
    inward = guess.shown.inward(guess.homography)
    inward = refine_from_afar(guess.shown.a, guess.shown.b, inward, settings.refine, settings.fine)
    return guess.shown.outward(inward), agreement(guess.shown.a, guess.shown.b, inward, 1)


def _guessed(a: Prepared, b: Prepared, matched: Correspondence, settings: RegistrationSettings) -> _Guess | None:
    """What the matches say as far as it costs little: for the way back."""
    found = _by_matches(matched, settings)
    if found.homography is None:
        return None
    guess = _better(found.homography, a, b, settings, False)
    is_shown = _shares_enough(guess.homography, a, b, settings)
    return guess if is_shown and guess.agreement >= settings.min_agreement else None


def _accepted(
    guess: _Guess,
    found: Registration,
    matched: Correspondence,
    a: Prepared,
    b: Prepared,
    settings: RegistrationSettings,
) -> Registration:
    """The guess made exact, or why it must not be believed.

    All clustered matches are asked again: those that were off by a little agree with the exact one, and where a bush
    before a wall had most of the matches, the wall has most of the picture.
    """
    homography, alike = _exact(guess, settings)
    exact = supported(homography, matched, settings)
    if not guess.by_similarity and exact.inliers < settings.min_kept * found.inliers:
        assert found.homography is not None
        homography, alike, exact = found.homography, guess.agreement, found
    if impossible(homography, a.shape):
        return refused(impossible(homography, a.shape), matched, exact.inliers)
    if not _shares_enough(homography, a, b, settings):
        return refused("the pictures overlap too little", matched, exact.inliers)
    if alike < settings.min_agreement:
        return refused("the pictures differ where they overlap", matched, exact.inliers)
    return replace(exact, agreement=alike)


def _accepted_similarity(
    guess: _Guess,
    found: Registration,
    matched: Correspondence,
    a: Prepared,
    b: Prepared,
    settings: RegistrationSettings,
) -> Registration:
    """A similarity made exact, believed alone where the pictures share and agree on more; else why the first failed."""
    homography, alike = _exact(guess, settings)
    tolerance = forgiving_px(matched.shape_b, settings)
    apart = distances(homography, matched.all_a, matched.all_b)
    if int((apart <= settings.inlier_px).sum()) < settings.coarse_kept or impossible(homography, a.shape):
        return found
    if min(_both_overlaps(homography, a, b)) < settings.coarse_overlap or alike < settings.coarse_agreement:
        return found
    if disagreeing_share(guess.shown.a, guess.shown.b, guess.shown.inward(homography), 1) > settings.coarse_apart:
        return found
    close = apart <= tolerance
    forgiven = replace(matched, clustered_a=matched.all_a[close], clustered_b=matched.all_b[close])
    return replace(supported(homography, forgiven, settings), agreement=alike)


def _shares_enough(homography: Points, a: Prepared, b: Prepared, settings: RegistrationSettings) -> bool:
    """Each picture shows enough of the other; of two scales, the coarser one most of the finer."""
    shared = _both_overlaps(homography, a, b)
    zoom = zoom_of(homography, a.shape)
    if 1.0 / settings.one_scale <= zoom <= settings.one_scale:
        return min(shared) >= settings.min_overlap
    return max(shared) >= settings.min_overlap_zoomed


def _both_overlaps(homography: Points, a: Prepared, b: Prepared) -> tuple[float, float]:
    inverse = np.asarray(np.linalg.inv(homography), np.float64)
    return overlap(homography, a.shape, b.shape), overlap(inverse, b.shape, a.shape)


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


def _by_similarity(matched: Correspondence, settings: RegistrationSettings) -> Points | None:
    """A similarity (3, 3): parallax, blur or a change of scale leave few matches to a homography of 3 px.

    A similarity needs but two matches and forgives more: it only has to bring the pictures near enough to each other
    for the refinement. None where too few matches agree with it, or where nearly as many agree with another (of two
    windows that look alike, which?).
    """
    points_a, points_b = matched.all_a, matched.all_b
    if len(points_a) < settings.coarse_inliers:
        return None
    tolerance = forgiving_px(matched.shape_b, settings)
    near, agree = similarity(points_a, points_b, tolerance, settings)
    if near is None or agree.sum() < settings.coarse_inliers:
        return None
    _, elsewhere = similarity(points_a[~agree], points_b[~agree], tolerance, settings)
    return near if elsewhere.sum() <= settings.coarse_rival * agree.sum() else None
