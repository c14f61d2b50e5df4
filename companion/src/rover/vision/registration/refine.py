"""A homography made exact: the first picture laid on the second by it, and the rest measured by optical flow.

ORB's keypoints lie up to a pixel off, more at the coarser levels, and their views differ by the very homography that is
wanted. Once the pictures nearly coincide, small windows can be compared directly and to a fraction of a pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.homography import apply_homography

Points = NDArray[np.float64]


# Of the flow at one point: so many steps, or until one moves it by less, pixels.
ENOUGH = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 10, 0.03)


@dataclass(frozen=True)
class RefineSettings:
    """rounds: how often the picture is laid on again. corners, quality, distance: points to be tracked.

    spacing: least distance between them, a share of the picture's width: what is textured must not take them all.
    window: side of the compared windows; halvings: in how many smaller pictures they are compared first.
    round_trip_px: how far a point may land from its start when tracked back.
    scale_px: where a residual begins to count less (Cauchy). min_points: fewer change nothing.
    max_shift_px: a correction beyond what the windows can bridge is none.
    """

    rounds: int = 1
    corners: int = 500
    quality: float = 0.005
    distance: int = 5
    spacing: float = 0.02
    window: int = 15
    halvings: int = 1
    round_trip_px: float = 0.5
    scale_px: float = 0.5
    min_points: int = 25
    max_shift_px: float = 20.0


def refine_homography(
    picture_a: NDArray[np.uint8], picture_b: NDArray[np.uint8], homography: Points, settings: RefineSettings
) -> Points:
    """The homography (3, 3) from A to B, improved; returned as it came where too few points can be tracked.

    Pictures (H, W) uint8 of equal contrast. `homography` must be right to within the tracking window.
    """
    refined = homography
    for _ in range(settings.rounds):
        laid = lay(picture_a, picture_b, refined)
        if laid is None:
            return homography
        start, end = _corners_followed(*laid, picture_b, settings)
        if len(start) < settings.min_points:
            return homography
        step = fit_homography(start, end, settings.scale_px)
        corners = start[[start[:, 0].argmin(), start[:, 0].argmax(), start[:, 1].argmin(), start[:, 1].argmax()]]
        if step is None or np.abs(apply_homography(step, corners) - corners).max() > settings.max_shift_px:
            return homography
        refined = step @ refined
        refined = refined / refined[2, 2]
    return refined


def refine_from_afar(
    pyramid_a: Sequence[NDArray[np.uint8]],
    pyramid_b: Sequence[NDArray[np.uint8]],
    homography: Points,
    settings: RefineSettings,
    levels: Sequence[int],
) -> Points:
    """As `refine_homography`, from a guess that is off by more: first in pictures halved, so that only what is large
    in them counts. In full pictures the windows would fit bricks and blades of grass to their neighbours.

    levels: how often the pictures are halved, the smallest first.
    """
    for level in levels:
        smaller = np.diag((0.5**level, 0.5**level, 1.0))
        guess = smaller @ homography @ np.linalg.inv(smaller)
        refined = refine_homography(pyramid_a[level], pyramid_b[level], guess / guess[2, 2], settings)
        homography = np.linalg.inv(smaller) @ refined @ smaller
        homography = homography / homography[2, 2]
    return homography


def fit_homography(start: Points, end: Points, scale_px: float, iterations: int = 12) -> Points | None:
    """The homography (3, 3) near the identity that takes `start` (N, 2) to `end` (N, 2), N ≥ 4, in a robust sense.

    Gauss-Newton on the reprojection error, each point weighted by 1 / (1 + (r / scale_px)²) (Cauchy's estimator): a
    threshold would keep what lies just inside it at full weight. None when the points don't determine it.
    """
    centre = start.mean(axis=0)
    spread = max(float(np.abs(start - centre).max()), 1.0)
    x, y = ((start - centre) / spread).T
    u, v = ((end - centre) / spread).T
    ones, zeros = np.ones_like(x), np.zeros_like(x)
    entries = np.eye(3).ravel()
    for _ in range(iterations):
        h = entries.reshape(3, 3)
        w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        if np.any(w < 0.1):
            return None
        at_u = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w
        at_v = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w
        left_u, left_v = u - at_u, v - at_v
        weight = 1.0 / (1.0 + (left_u**2 + left_v**2) * (spread / scale_px) ** 2)
        rows_u = np.stack((x, y, ones, zeros, zeros, zeros, -x * at_u, -y * at_u), axis=1) / w[:, None]
        rows_v = np.stack((zeros, zeros, zeros, x, y, ones, -x * at_v, -y * at_v), axis=1) / w[:, None]
        normal = (rows_u * weight[:, None]).T @ rows_u + (rows_v * weight[:, None]).T @ rows_v
        pull = rows_u.T @ (weight * left_u) + rows_v.T @ (weight * left_v)
        try:
            entries[:8] += np.linalg.solve(normal, pull)
        except np.linalg.LinAlgError:
            return None
    to_unit = np.array([[1 / spread, 0, -centre[0] / spread], [0, 1 / spread, -centre[1] / spread], [0, 0, 1]])
    fitted = np.linalg.inv(to_unit) @ entries.reshape(3, 3) @ to_unit
    return fitted / fitted[2, 2] if np.isfinite(fitted).all() else None


def lay(
    picture_a: NDArray[np.uint8], picture_b: NDArray[np.uint8], homography: Points
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]] | None:
    """A in B's frame, and where it has pixels, away from its edge; None when hardly anything is left."""
    size = picture_b.shape[1], picture_b.shape[0]
    laid = cv2.warpPerspective(picture_a, homography, size, flags=cv2.INTER_LINEAR)
    mask = cv2.warpPerspective(np.full(picture_a.shape, 255, np.uint8), homography, size, flags=cv2.INTER_NEAREST)
    mask = cv2.erode(mask, np.ones((15, 15), np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=0)
    if cv2.countNonZero(mask) <= 0.01 * mask.size:
        return None
    return np.asarray(laid, np.uint8), np.asarray(mask, np.uint8)


def follow(
    laid: NDArray[np.uint8], picture_b: NDArray[np.uint8], points: Points, settings: RefineSettings
) -> tuple[Points, NDArray[np.bool_]]:
    """Where `points` (N, 2) of the laid picture lie in B, and which of them (N,) came back to their start."""
    if len(points) == 0:
        return np.empty((0, 2)), np.empty(0, bool)
    start = points.astype(np.float32).reshape(-1, 1, 2)
    window = (settings.window, settings.window)
    # The stub does not know that the end points may be None, as in OpenCV's own examples.
    how = {"winSize": window, "maxLevel": settings.halvings, "criteria": ENOUGH}
    there, found, _ = cv2.calcOpticalFlowPyrLK(laid, picture_b, start, None, **how)  # type: ignore[call-overload]
    back, returned, _ = cv2.calcOpticalFlowPyrLK(picture_b, laid, there, None, **how)  # type: ignore[call-overload]
    apart = np.linalg.norm((back - start).reshape(-1, 2), axis=1)
    good = (found.ravel() == 1) & (returned.ravel() == 1) & (apart <= settings.round_trip_px)
    return there.reshape(-1, 2).astype(np.float64), good


def strongest_corners(
    picture: NDArray[np.uint8], count: int, quality: float, distance: float, mask: NDArray[np.uint8] | None = None
) -> Points:
    """At most `count` corners (N, 2) at least `distance` pixels apart where `mask` is not 0, strongest first."""
    corners = cv2.goodFeaturesToTrack(picture, count, quality, distance, mask=mask)
    if corners is None:
        return np.empty((0, 2))  # type: ignore[unreachable]  # the stub does not know that there may be none
    return corners.reshape(-1, 2).astype(np.float64)


def _corners_followed(
    laid: NDArray[np.uint8], mask: NDArray[np.uint8], picture_b: NDArray[np.uint8], settings: RefineSettings
) -> tuple[Points, Points]:
    distance = max(settings.distance, settings.spacing * laid.shape[1])
    start = strongest_corners(laid, settings.corners, settings.quality, distance, mask)
    there, good = follow(laid, picture_b, start, settings)
    return start[good], there[good]
