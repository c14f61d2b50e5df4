"""Where the rover stands, from points on the ground whose places in map are known: Perspective-n-Point (section 3.3).

First the general solution with RANSAC, which says which matches belong together; then, because the camera is bolted to
the rover and the rover stands on the ground, the same points fitted with the three unknowns that are left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.vision.camera import CameraModel

Points = NDArray[np.float64]


@dataclass(frozen=True)
class GroundPoseSettings:
    """reprojection_px: RANSAC's inlier bound. min_base: metres between the two points of a hypothesis.

    pixel_sigma: least error of a keypoint that is believed, pixels.

    min_inliers, min_ratio: fewer, or a smaller share, is a refusal. max_tilt: radians by which the general solution may
    differ from the camera's mount; more means that it is wrong.
    """

    reprojection_px: float = 2.0
    iterations: int = 80
    min_base: float = 0.15
    pixel_sigma: float = 0.4
    min_inliers: int = 12
    min_ratio: float = 0.3
    max_tilt: float = math.radians(12.0)
    seed: int = 1


@dataclass(frozen=True, eq=False)
class GroundPose:
    """pose: of base_link in map. covariance: (3, 3) of x, y, heading. inliers: which of the points fitted, (N,) bool.

    residual_px: root mean square error of the inliers in the picture.
    """

    pose: Pose2
    covariance: NDArray[np.float64]
    inliers: NDArray[np.bool_]
    residual_px: float


def solve_ground_pose(
    camera: CameraModel, map_points: Points, pixels: Points, prior: Pose2, settings: GroundPoseSettings
) -> GroundPose | str:
    """Pose from ground points of map (N, 2) seen at pixels (N, 2); a text says why there is none."""
    if len(map_points) < settings.min_inliers:
        return "too few matches"
    normalized = camera.pixel_to_normalized(pixels)
    inliers = _ransac(camera, map_points, normalized, prior, settings)
    if inliers is None:
        return "no pose agrees with the matches"
    pose = prior
    for _ in range(2):
        if inliers.sum() < max(settings.min_inliers, settings.min_ratio * len(map_points)):
            return "too few matches agree"
        fitted = _fit(camera, map_points[inliers], normalized[inliers], pose)
        if fitted is None:
            return "the matches do not determine a pose"
        pose, information = fitted
        error = camera.fx * np.linalg.norm(_residuals(camera, map_points, normalized, pose), axis=1)
        inliers = error <= settings.reprojection_px
    count = int(inliers.sum())
    if count < max(settings.min_inliers, settings.min_ratio * len(map_points)):
        return "too few matches agree"
    residual = float(np.sqrt(np.mean(error[inliers] ** 2)))
    sigma = max(residual, settings.pixel_sigma) / camera.fx
    covariance = np.linalg.inv(information) * sigma**2
    return GroundPose(pose, 0.5 * (covariance + covariance.T), inliers, residual)


def _ransac(
    camera: CameraModel, map_points: Points, normalized: Points, prior: Pose2, settings: GroundPoseSettings
) -> NDArray[np.bool_] | None:
    """Matches that one pose of the rover explains, from hypotheses of two matches each; None when there are too few.

    Two points on the ground fix the three unknowns. The winner's matches must also agree with PnP of all six: a tilt
    that contradicts the mount means that they lie on something else than the ground.
    """
    base = _on_ground(camera, normalized)
    # A pixel is the longer on the ground the flatter it is looked at: slant² / (height · focal length).
    slant2 = (base[:, 0] - camera.x) ** 2 + (base[:, 1] - camera.y) ** 2 + camera.z**2
    tolerance = settings.reprojection_px * slant2 / (camera.z * camera.fx)
    generator = np.random.default_rng(settings.seed)
    pairs = generator.integers(0, len(base), (settings.iterations, 2))
    d_base, d_map = base[pairs[:, 1]] - base[pairs[:, 0]], map_points[pairs[:, 1]] - map_points[pairs[:, 0]]
    length = np.hypot(d_base[:, 0], d_base[:, 1])
    stretch = np.abs(np.hypot(d_map[:, 0], d_map[:, 1]) - length)
    usable = (length > settings.min_base) & (stretch < tolerance[pairs].sum(axis=1))
    if not usable.any():
        return None
    pairs, d_base, d_map = pairs[usable], d_base[usable], d_map[usable]
    turn = np.arctan2(d_map[:, 1], d_map[:, 0]) - np.arctan2(d_base[:, 1], d_base[:, 0])
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = c * base[:, 0] - s * base[:, 1], s * base[:, 0] + c * base[:, 1]
    dx, dy = map_points[:, 0] - x, map_points[:, 1] - y
    rows = np.arange(len(pairs))[:, None]
    dx -= dx[rows, pairs].mean(axis=1, keepdims=True)
    dy -= dy[rows, pairs].mean(axis=1, keepdims=True)
    agrees = dx * dx + dy * dy < tolerance**2
    inliers = agrees[int(np.argmax(agrees.sum(axis=1)))]
    if inliers.sum() < settings.min_inliers:
        return None
    world = np.column_stack((map_points[inliers] - (prior.x, prior.y), np.zeros(int(inliers.sum()))))
    found, rotation, _ = cv2.solvePnP(world, normalized[inliers], np.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
    up = cv2.Rodrigues(rotation)[0][:, 2]
    if not found or math.acos(float(np.clip(up @ camera.extrinsic[:3, 2], -1.0, 1.0))) > settings.max_tilt:
        return None
    return inliers


def _on_ground(camera: CameraModel, normalized: Points) -> Points:
    """Directions (N, 2) on the plane one ahead of the lens to base_link (N, 2)."""
    rays = np.column_stack((normalized, np.ones(len(normalized)))) @ camera.base_from_camera.T
    return rays[:, :2] * (camera.z / -rays[:, 2:]) + (camera.x, camera.y)


def _residuals(camera: CameraModel, map_points: Points, normalized: Points, pose: Pose2) -> Points:
    base = pose.inverse().transform(map_points)
    return camera.ground_to_normalized(base)[0] - normalized


def _fit(
    camera: CameraModel, map_points: Points, normalized: Points, pose: Pose2
) -> tuple[Pose2, NDArray[np.float64]] | None:
    """Gauss–Newton over x, y, heading with Huber weights; the pose and JᵀWJ on the plane one ahead of the lens."""
    rotation, position = camera.extrinsic[:3, :2], camera.extrinsic[:3, 3]
    count = len(map_points)
    jacobian = np.empty((2 * count, 3))
    information = np.eye(3)
    for _ in range(5):
        c, s = math.cos(pose.heading), math.sin(pose.heading)
        dx, dy = map_points[:, 0] - pose.x, map_points[:, 1] - pose.y
        base_x, base_y = c * dx + s * dy, c * dy - s * dx
        point = rotation @ np.stack((base_x, base_y)) + position[:, None]
        depth = point[2]
        if depth.min() <= 0.05:
            return None
        seen = point[:2] / depth
        residual = seen - normalized.T
        for axis in range(2):
            # d(seen)/d(base x, base y), then d(base)/d(x, y, heading)
            lens_x = (rotation[axis, 0] - seen[axis] * rotation[2, 0]) / depth
            lens_y = (rotation[axis, 1] - seen[axis] * rotation[2, 1]) / depth
            rows = jacobian[axis * count : (axis + 1) * count]
            rows[:, 0] = s * lens_y - c * lens_x
            rows[:, 1] = -s * lens_x - c * lens_y
            rows[:, 2] = base_y * lens_x - base_x * lens_y
        size = np.hypot(residual[0], residual[1])
        bound = 1.5 * max(float(np.median(size)), 0.2 / camera.fx)
        weight = np.tile(np.minimum(1.0, bound / np.maximum(size, 1e-12)), 2)
        weighted = (jacobian * weight[:, None]).T
        information = weighted @ jacobian
        try:
            step = np.linalg.solve(information, -weighted @ residual.ravel())
        except np.linalg.LinAlgError:
            return None
        pose = Pose2(pose.x + step[0], pose.y + step[1], pose.heading + step[2])
        if np.abs(step).max() < 1e-5:
            break
    if np.linalg.cond(information) > 1e8:
        return None
    return pose, information
