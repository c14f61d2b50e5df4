"""Where the rover stands, from ground points that are known and where the camera sees them (sections 3.3, 4.3).

Perspective-n-Point with every point on the plane z = 0 and the camera on its known mount. First a consensus tells
inliers from outliers, then a robust Gauss-Newton over (x, y, heading) alone minimises the reprojection error: the
mount is rigid, so the other three degrees of freedom of a free PnP would only take up noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle
from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Iterations that are enough to tell which points fit.
COARSE = 2

# A step of so many metres and radians together is far below any noise.
CONVERGED = 1e-5

_REGULAR = 1e-9 * np.eye(3)


@dataclass(frozen=True)
class GroundPoseSettings:
    """consensus: "planar" (two-point hypotheses on the ground) or "pnp" (OpenCV's solvePnPRansac, six degrees).

    tolerance_px: reprojection error of an inlier. sigma_px: least noise of a keypoint, one axis.
    hypotheses: tried by the planar consensus. seed: of the random choices; same input, same result.
    """

    consensus: str = "planar"
    tolerance_px: float = 2.5
    sigma_px: float = 0.5
    hypotheses: int = 96
    iterations: int = 6
    min_inliers: int = 10
    seed: int = 7


@dataclass(frozen=True, eq=False)
class GroundPose:
    """pose: base_link in the frame of the known points; covariance (3, 3) of (x, y, heading), metres and radians.

    inliers: (N,) of the points given. residual_px: rms reprojection error of the inliers, one axis.
    """

    pose: Pose2
    covariance: Points
    inliers: Mask = field(repr=False)
    residual_px: float

    @property
    def count(self) -> int:
        """Number of inliers."""
        return int(self.inliers.sum())


def solve_ground_pose(
    known: Points, seen: Points, camera: CameraModel, settings: GroundPoseSettings, noise: Points | None = None
) -> GroundPose | None:
    """The pose from which ground points are seen where they are; None when too few of them agree.

    known: (N, 2) in the outer frame (map, or a keyframe's). seen: (N, 2) the same points in base_link as the picture
    shows them (`CameraModel.pixel_to_ground`). noise: (N,) relative standard deviations, 1 when not given.
    """
    if len(known) < settings.min_inliers:
        return None
    normalized, depth = camera.ground_to_normalized(seen)
    weight_sigma = np.ones(len(known)) if noise is None else noise
    if settings.consensus == "pnp":
        inliers = consensus_pnp(known, normalized, camera, settings)
    else:
        inliers = consensus_planar(known, seen, metres_per_pixel(depth, camera), settings)
    if inliers is None or inliers.sum() < settings.min_inliers:
        return None
    start = rigid_fit(known[inliers], seen[inliers])
    pose, _, _ = refine(known[inliers], normalized[inliers], camera, start, settings, weight_sigma[inliers], COARSE)
    # Once more with every point that fits the refined pose: the consensus saw it through two noisy points only.
    error = reprojection_error(known, normalized, camera, pose)
    inliers = error <= settings.tolerance_px * weight_sigma
    if inliers.sum() < settings.min_inliers:
        return None
    pose, covariance, residual = refine(
        known[inliers], normalized[inliers], camera, pose, settings, weight_sigma[inliers]
    )
    return GroundPose(pose, covariance, inliers, residual)


def metres_per_pixel(depth: Points, camera: CameraModel) -> Points:
    """Ground covered by a pixel (N,), geometric mean of its two sides, at points of this depth (N,).

    A ray of depth Z that meets the plane covers (Z/f)² · Z/h of it, h being the camera's height.
    """
    focal_squared = camera.fx * camera.fy
    return np.sqrt(np.maximum(depth, 1e-6) ** 3 / (focal_squared * camera.z))


def consensus_planar(known: Points, seen: Points, pixel_m: Points, settings: GroundPoseSettings) -> Mask | None:
    """Inliers (N,) of the best of many two-point rigid hypotheses, all tested at once; None when there is none."""
    count = len(known)
    if count < 2:
        return None
    rng = np.random.Generator(np.random.PCG64(settings.seed))
    first = rng.integers(0, count, settings.hypotheses)
    second = (first + rng.integers(1, count, settings.hypotheses)) % count
    # Complex numbers: known = turn · seen + shift, with |turn| = 1.
    g = known[:, 0] + 1j * known[:, 1]
    s = seen[:, 0] + 1j * seen[:, 1]
    across_g, across_s = g[second] - g[first], s[second] - s[first]
    length_g, length_s = np.abs(across_g), np.abs(across_s)
    tolerance = settings.tolerance_px * pixel_m
    fits = (np.abs(length_g - length_s) <= tolerance[first] + tolerance[second]) & (length_s > 0.05)
    if not fits.any():
        return None
    turn = (across_g[fits] * across_s[fits].conj()) / (length_g[fits] * length_s[fits] + 1e-12)
    shift = 0.5 * (g[first[fits]] + g[second[fits]]) - turn * (0.5 * (s[first[fits]] + s[second[fits]]))
    # Every hypothesis moves every point in one product; single precision is a micrometre here.
    rows = np.vstack((seen.T, np.ones(count))).astype(np.float32)
    by_x = np.column_stack((turn.real, -turn.imag, shift.real)).astype(np.float32)
    by_y = np.column_stack((turn.imag, turn.real, shift.imag)).astype(np.float32)
    off_x, off_y = by_x @ rows, by_y @ rows
    off_x -= known[:, 0].astype(np.float32)
    off_y -= known[:, 1].astype(np.float32)
    off_x *= off_x
    off_y *= off_y
    off_x += off_y
    agree = off_x <= np.square(1.5 * tolerance).astype(np.float32)
    best: Mask = agree[int(agree.sum(axis=1).argmax())]
    return best


def consensus_pnp(known: Points, normalized: Points, camera: CameraModel, settings: GroundPoseSettings) -> Mask | None:
    """Inliers (N,) by OpenCV's RANSAC over a free camera pose (six degrees); None when there is none."""
    cv2.setRNGSeed(settings.seed)
    points = np.column_stack((known, np.zeros(len(known))))
    pixels = normalized * (camera.fx, camera.fy)
    k = np.diag((camera.fx, camera.fy, 1.0))
    try:
        found, _, _, chosen = cv2.solvePnPRansac(
            points, pixels, k, None, iterationsCount=100, reprojectionError=settings.tolerance_px
        )
    except cv2.error:
        return None
    if not found or chosen is None:
        return None
    inliers = np.zeros(len(known), dtype=bool)
    inliers[chosen.ravel()] = True
    return inliers


def rigid_fit(known: Points, seen: Points) -> Pose2:
    """Least-squares turn and shift with known = pose ∘ seen, (N, 2) each."""
    g = known[:, 0] + 1j * known[:, 1]
    s = seen[:, 0] + 1j * seen[:, 1]
    turn = np.sum((g - g.mean()) * (s - s.mean()).conj())
    heading = float(np.angle(turn))
    shift = g.mean() - np.exp(1j * heading) * s.mean()
    return Pose2(float(shift.real), float(shift.imag), heading)


def reprojection_error(known: Points, normalized: Points, camera: CameraModel, pose: Pose2) -> Points:
    """Distance in pixels (N,) between where the points are seen and where they would be from `pose`."""
    expected, _ = camera.ground_to_normalized(pose.inverse().transform(known))
    off_u, off_v = ((expected - normalized) * (camera.fx, camera.fy)).T
    return np.asarray(np.hypot(off_u, off_v))


def refine(
    known: Points,
    normalized: Points,
    camera: CameraModel,
    start: Pose2,
    settings: GroundPoseSettings,
    noise: Points,
    iterations: int = 0,
) -> tuple[Pose2, Points, float]:
    """Robust Gauss-Newton from `start`: pose, covariance (3, 3), rms residual of one axis in pixels.

    iterations: at most so many, 0 for the setting. Huber weights. The covariance is scaled up, never down, when the
    residuals are larger than `sigma_px`.
    """
    mount = camera.extrinsic
    rotation, shift = mount[:3, :2], mount[:3, 3:]
    scale = np.array([[camera.fx], [camera.fy]]) / noise
    seen, points = normalized.T, known.T
    x, y, heading = start.x, start.y, start.heading
    knee = 1.5 * settings.sigma_px * math.sqrt(2.0)
    jacobian = np.empty((3, 2, len(known)))
    for _ in range(iterations or settings.iterations):
        c, s = math.cos(heading), math.sin(heading)
        # The mount turned with the rover: its columns are the axes of the known points in the camera.
        turned = rotation @ np.array([[c, s], [-s, c]])
        offset = points - np.array([[x], [y]])
        in_camera = turned @ offset + shift
        inverse_depth = 1.0 / in_camera[2]
        projected = in_camera[:2] * inverse_depth
        residual = (projected - seen) * scale
        squared = residual[0] * residual[0] + residual[1] * residual[1]
        weight = np.minimum(1.0, knee / np.sqrt(np.maximum(squared, 1e-24)))
        # d(pixel)/d(x), d(y); a turn moves every point across its offset.
        steep = scale * inverse_depth
        for axis in (0, 1):
            jacobian[axis] = (projected * turned[2, axis] - turned[:2, axis : axis + 1]) * steep
        jacobian[2] = jacobian[1] * offset[0] - jacobian[0] * offset[1]
        weighted = (jacobian * weight).reshape(3, -1)
        information = weighted @ jacobian.reshape(3, -1).T
        step = np.linalg.solve(information + _REGULAR, -weighted @ residual.ravel()).tolist()
        x, y, heading = x + step[0], y + step[1], heading + step[2]
        if abs(step[0]) + abs(step[1]) + abs(step[2]) < CONVERGED:
            break
    # Huber's weighted sum of squares estimates the noise of one axis; three degrees of freedom are used up.
    freedom = max(1.0, 2.0 * float(weight.sum()) - 3.0)
    variance = float(weight @ squared) / freedom
    rms = math.sqrt(float(squared.mean()) / 2.0)
    covariance = max(settings.sigma_px**2, variance) * np.linalg.inv(information + _REGULAR)
    return Pose2(x, y, wrap_angle(heading)), covariance, rms
