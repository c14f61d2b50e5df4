"""Intrinsics from views of a board: focal lengths, centre, skew and distortion (eq. 8) by what they do to its points.

Zhang's closed form gives the start (OpenCV), the rest is one adjustment over all views. A set of views that does not
determine the camera is refused: it fits as well as a good one, and is worthless.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.vision.calibration.fit import Fit, fit, rigid
from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]

MIN_VIEWS = 3
# At least two views must differ by this much in how the board is tilted.
MIN_TILT = math.radians(10.0)

# Largest standard deviation of the focal length, as a share of it, with which a calibration is given out.
MAX_FOCAL_SIGMA = 0.02

# Reprojection error, as a share of the picture's width, beyond which the points are not those of the board.
MAX_RMS_SHARE = 0.02

COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True)
class Freedom:
    """What is estimated. distortion: how many of k1, k2, p1, p2, k3. square: fx = fy. centre: else the middle."""

    distortion: int = 4
    skew: bool = False
    square: bool = False
    centre: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters in the order of `Calibration.covariance`."""
        focal = ("f",) if self.square else ("fx", "fy")
        centre = ("cx", "cy") if self.centre else ()
        return (*focal, *centre, *(("skew",) if self.skew else ()), *COEFFICIENTS[: self.distortion])


@dataclass(frozen=True)
class Calibration:
    """camera: the result. names, covariance: of its parameters, pixels. rms, view_rms: reprojection, pixels.

    tilts: (V,) angle between the board's normal and the optical axis, radians. coverage: share of the picture in
    the bounding boxes of the points of all views together.
    """

    camera: CameraModel
    names: tuple[str, ...]
    covariance: Points
    rms: float
    view_rms: Points
    tilts: Points
    coverage: float

    @property
    def sigmas(self) -> dict[str, float]:
        """Standard deviation of each parameter."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))


def calibrate(
    points: Points, views: Sequence[Points], size: tuple[int, int], freedom: Freedom, name: str = "camera"
) -> Calibration:
    """The camera that saw `points` (N, 3), on a plane, at `views` (N, 2) each in pictures of `size` (width, height).

    Raises BadInput, one line, when the views are too few or do not determine the camera.
    """
    if len(views) < MIN_VIEWS:
        raise BadInput(f"calibration: the board was found in {len(views)} pictures, at least {MIN_VIEWS} are needed")
    observed = np.stack(views)
    start = _start(points, observed, size, name)
    poses = np.stack([board_pose(start, points, view) for view in observed])
    plain = replace(freedom, distortion=0, skew=False)
    rough = fit_views(points, observed, start, plain, poses)
    result = fit_views(points, observed, _with(start, plain, rough.shared), freedom, rough.poses)
    found = _calibration(start, freedom, result, observed)
    _check(found, result.poses)
    return found


def calibrated(points: Points, observed: Points, start: CameraModel, freedom: Freedom) -> Calibration:
    """As `calibrate`, from a given start and without its checks: for targets that determine less than a board."""
    poses = np.stack([board_pose(start, points, view) for view in observed])
    return _calibration(start, freedom, fit_views(points, observed, start, freedom, poses), observed)


def fit_views(points: Points, observed: Points, camera: CameraModel, freedom: Freedom, poses: Points) -> Fit:
    """The adjustment of one camera over all views (V, N, 2), from a start."""

    def residuals(shared: Points, moved: Points) -> Points:
        return (project(_with(camera, freedom, shared), rigid(moved, points)) - observed).reshape(len(observed), -1)

    return fit(residuals, _parameters(camera, freedom), poses)


def project(camera: CameraModel, points: Points) -> Points:
    """Points (V, N, 3) of the optical frame to pixels (V, N, 2); what is behind the camera is put far outside."""
    depth = np.maximum(points[..., 2], 1e-6)
    normalized = points[..., :2] / depth[..., None]
    return camera.normalized_to_pixel(normalized.reshape(-1, 2)).reshape(normalized.shape)


def board_pose(camera: CameraModel, points: Points, view: Points) -> Points:
    """The board's pose (6,), rotation vector and translation in the optical frame, from one view (N, 2)."""
    normalized = camera.pixel_to_normalized(view)
    good, rotations, translations, errors = cv2.solvePnPGeneric(
        points, normalized, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    if not good:
        raise BadInput("calibration: a view of the board is degenerate: its points lie on one line")
    best = int(np.argmin(np.asarray(errors).ravel()))
    return np.concatenate((rotations[best].ravel(), translations[best].ravel()))


def _start(points: Points, observed: Points, size: tuple[int, int], name: str) -> CameraModel:
    width, height = size
    objects = [points.astype(np.float32)] * len(observed)
    pictures = [view.astype(np.float32) for view in observed]
    try:
        matrix = cv2.initCameraMatrix2D(objects, pictures, size, 0.0)
        focal = [float(value) for value in (matrix[0, 0], matrix[1, 1])]
    except cv2.error:
        focal = [math.nan, math.nan]
    # Noise on views from the front makes the closed form meaningless; what follows finds out.
    usable = all(math.isfinite(f) and 0.2 * width < f < 20.0 * width for f in focal)
    fx, fy = focal if usable else (float(width), float(width))
    return CameraModel(name, width, height, fx, fy, (width - 1) / 2.0, (height - 1) / 2.0)


def _parameters(camera: CameraModel, freedom: Freedom) -> Points:
    values: list[float] = [camera.fx] if freedom.square else [camera.fx, camera.fy]
    values += [camera.cx, camera.cy] if freedom.centre else []
    values += [camera.skew] if freedom.skew else []
    values += (*camera.distortion, *([0.0] * 5))[: freedom.distortion]
    return np.array(values)


def _with(camera: CameraModel, freedom: Freedom, shared: Points) -> CameraModel:
    values = dict(zip(freedom.names, shared.tolist(), strict=True))
    bent = [values.get(coefficient, 0.0) for coefficient in COEFFICIENTS]
    return replace(
        camera,
        fx=values.get("f", values.get("fx", camera.fx)),
        fy=values.get("f", values.get("fy", camera.fy)),
        cx=values.get("cx", camera.cx),
        cy=values.get("cy", camera.cy),
        skew=values.get("skew", 0.0),
        distortion=tuple(bent) if freedom.distortion else (),
    )


def _calibration(start: CameraModel, freedom: Freedom, result: Fit, observed: Points) -> Calibration:
    camera = _with(start, freedom, result.shared)
    coverage = _coverage(observed, (camera.width, camera.height))
    tilts = _tilts(result.poses)
    return Calibration(camera, freedom.names, result.covariance, result.rms, result.view_rms, tilts, coverage)


def _normals(poses: Points) -> Points:
    normals = np.stack([cv2.Rodrigues(pose[:3])[0][:, 2] for pose in poses])
    facing: Points = normals * np.sign(normals[:, 2:])  # a board has no back
    return facing


def _tilts(poses: Points) -> Points:
    return np.arccos(np.clip(_normals(poses)[:, 2], -1.0, 1.0))


def _coverage(observed: Points, size: tuple[int, int]) -> float:
    covered = np.zeros((size[1], size[0]), bool)
    for view in observed:
        low, high = np.floor(view.min(axis=0)).astype(int), np.ceil(view.max(axis=0)).astype(int)
        covered[max(0, low[1]) : high[1] + 1, max(0, low[0]) : high[0] + 1] = True
    return float(covered.mean())


def _check(found: Calibration, poses: Points) -> None:
    camera, sigmas = found.camera, found.sigmas
    normals = _normals(poses)
    spread = float(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)).max())
    focal = min(camera.fx, camera.fy)
    looseness = max(sigmas.get("f", 0.0), sigmas.get("fx", 0.0), sigmas.get("fy", 0.0)) / max(focal, 1e-9)
    if not math.isfinite(found.rms) or found.rms > MAX_RMS_SHARE * camera.width:
        raise BadInput(
            f"calibration: the points miss the board by {found.rms:.1f} px RMS: "
            "wrong numbers of columns and rows, or wrong points in a picture"
        )
    if spread < MIN_TILT or not 0.0 < looseness < MAX_FOCAL_SIGMA:
        raise BadInput(
            f"calibration: the {len(poses)} views do not determine the focal length "
            f"(it could be off by {min(looseness, 9.99):.1%}; the board's tilt differs by {math.degrees(spread):.0f}° "
            "at most): take some with the board tilted by 20° to 45° to each side"
        )
