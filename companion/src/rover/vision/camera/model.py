"""The camera: from base_link to pixels and back to the ground (equations 7 to 11 of the paper).

Equation 7 as printed multiplies by the inverse of K; projection needs K itself, and that is what stands here:
pixel ~ K · [R T] · X. The inverse serves the way back, from a pixel to its ray.

Pixel (0, 0) is the centre of the upper left pixel, so that the middle of the picture is ((W-1)/2, (H-1)/2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

Points = NDArray[np.float64]

# Columns: the optical axes x right, y down, z forward of a level camera that looks along base_link's x.
OPTICAL_IN_LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])

# Rays flatter than this (1.1°) meet the ground too far away to mean anything: they count as the horizon.
MIN_DEPRESSION_SINE = 0.02

# Enough for 1e-4 px at the corners of a lens with 20 % barrel distortion.
UNDISTORT_ITERATIONS = 30


def focal_from_fov(size_px: int, fov: float) -> float:
    """Focal length in pixels from a picture's side and the angle it spans in radians (eq. 9 and 10)."""
    return size_px / (2.0 * math.tan(fov / 2.0))


@dataclass(frozen=True)
class CameraModel:
    """Pinhole with skew and Brown-Conrady distortion (k1, k2, p1, p2, k3), on a rigid mount on base_link.

    Mount: metres, and radians roll, pitch, yaw about x, y, z (applied in this order; positive pitch looks down).
    """

    name: str
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    skew: float = 0.0
    distortion: tuple[float, ...] = ()
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    @staticmethod
    def from_fov(
        name: str, width: int, height: int, hfov: float, vfov: float | None = None
    ) -> CameraModel:
        """A camera known by its angles in radians (eq. 9, 10), not mounted; without `vfov` its pixels are square."""
        fx = focal_from_fov(width, hfov)
        fy = fx if vfov is None else focal_from_fov(height, vfov)
        return CameraModel(name, width, height, fx, fy, (width - 1) / 2.0, (height - 1) / 2.0)

    @cached_property
    def matrix(self) -> Points:
        """K, (3, 3) (eq. 8)."""
        return np.array([[self.fx, self.skew, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @cached_property
    def base_from_camera(self) -> Points:
        """Rotation (3, 3) whose columns are the optical axes in base_link."""
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        cp, sp = math.cos(self.pitch), math.sin(self.pitch)
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        rotation: Points = about_z @ about_y @ about_x @ OPTICAL_IN_LEVEL
        return rotation

    @property
    def position(self) -> Points:
        """The optical centre in base_link, (3,)."""
        return np.array([self.x, self.y, self.z])

    @cached_property
    def extrinsic(self) -> Points:
        """E, (4, 4): base_link to camera_optical (eq. 11)."""
        e = np.eye(4)
        e[:3, :3] = self.base_from_camera.T
        e[:3, 3] = -self.base_from_camera.T @ self.position
        return e

    def ground_to_normalized(self, points_base: Points) -> tuple[Points, Points]:
        """Ground points (N, 2) of base_link on the plane one ahead of the lens: (N, 2), and their depth (N,).

        No lens yet: u = fx·a + s·b + cx, v = fy·b + cy without distortion. A depth <= 0 is behind the camera.
        """
        e = self.extrinsic
        camera = np.asarray(points_base, dtype=np.float64) @ e[:3, :2].T + e[:3, 3]
        depth = camera[:, 2]
        ahead = np.where(depth > 1e-9, depth, np.nan)
        return camera[:, :2] / ahead[:, None], depth

    def ground_to_pixel(self, points_base: Points) -> Points:
        """Ground points (N, 2) of base_link to pixels (N, 2); nan behind the camera (eq. 7, 8, 11)."""
        normalized, _ = self.ground_to_normalized(points_base)
        return self.normalized_to_pixel(normalized)

    def normalized_to_pixel(self, normalized: Points) -> Points:
        """Applies distortion and K: (N, 2) to pixels (N, 2)."""
        if any(self.distortion):
            radial, tangential = self._lens(normalized)
            normalized = normalized * radial[:, None] + tangential
        a, b = normalized[:, 0], normalized[:, 1]
        return np.column_stack((self.fx * a + self.skew * b + self.cx, self.fy * b + self.cy))

    def _lens(self, normalized: Points) -> tuple[Points, Points]:
        """Brown-Conrady at undistorted coordinates (N, 2): radial factor (N,), tangential shift (N, 2)."""
        k1, k2, p1, p2, k3 = (*self.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
        a, b = normalized[:, 0], normalized[:, 1]
        r2 = a * a + b * b
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        along_a = 2.0 * p1 * a * b + p2 * (r2 + 2.0 * a * a)
        along_b = p1 * (r2 + 2.0 * b * b) + 2.0 * p2 * a * b
        return radial, np.column_stack((along_a, along_b))

    def pixel_to_normalized(self, uv: Points) -> Points:
        """Pixels (N, 2) to undistorted coordinates (N, 2) on the plane one ahead of the lens."""
        uv = np.asarray(uv, dtype=np.float64)
        b = (uv[:, 1] - self.cy) / self.fy
        a = (uv[:, 0] - self.cx - self.skew * b) / self.fx
        distorted = np.column_stack((a, b))
        if not any(self.distortion):
            return distorted
        # Fixed point: divide by the lens as it would be where we think the point is.
        plain = distorted
        for _ in range(UNDISTORT_ITERATIONS):
            radial, tangential = self._lens(plain)
            plain = (distorted - tangential) / radial[:, None]
        return plain

    def pixel_to_ground(self, uv: Points) -> Points:
        """Pixels (N, 2) to ground points (N, 2) in base_link; nan at and above the horizon."""
        normalized = self.pixel_to_normalized(uv)
        rays = np.column_stack((normalized, np.ones(len(normalized))))
        rays = (rays / np.linalg.norm(rays, axis=1, keepdims=True)) @ self.base_from_camera.T
        down = -rays[:, 2]
        reach = self.z / np.where(down > MIN_DEPRESSION_SINE, down, np.nan)
        ground: Points = rays[:, :2] * reach[:, None] + (self.x, self.y)
        return ground

    def check_size(self, shape: tuple[int, ...], name: str) -> None:
        """Raises BadInput naming the picture `name` whose shape (H, W) is not this camera's."""
        if shape != (self.height, self.width):
            size = f"{shape[1]}×{shape[0]}"
            raise BadInput(f"{name}: {size} pixels, the camera {self.name} has {self.width}×{self.height}")

    def undistort(self, picture: NDArray[Any]) -> NDArray[Any]:
        """The picture (H, W) as a lens without distortion would have shown it; its edge is drawn out where it must."""
        if not any(self.distortion):
            return picture
        v, u = np.mgrid[0 : self.height, 0 : self.width]
        plain = np.column_stack(((u.ravel() - self.cx - self.skew * (v.ravel() - self.cy) / self.fy) / self.fx,
                                 (v.ravel() - self.cy) / self.fy))  # fmt: skip
        source = self.normalized_to_pixel(plain).reshape(self.height, self.width, 2).astype(np.float32)
        straight: NDArray[Any] = cv2.remap(picture, source[..., 0], source[..., 1], cv2.INTER_LINEAR,
                                           borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
        return straight

    @cached_property
    def ground_lookup(self) -> NDArray[np.float32]:
        """The ground point in base_link of every pixel, (H, W, 2) float32, nan above the horizon; read-only."""
        v, u = np.mgrid[0 : self.height, 0 : self.width]
        uv = np.column_stack((u.ravel(), v.ravel())).astype(np.float64)
        table = self.pixel_to_ground(uv).reshape(self.height, self.width, 2).astype(np.float32)
        table.setflags(write=False)
        return table

    def inside(self, uv: Points, margin: float = 0.0) -> NDArray[np.bool_]:
        """Which pixels (N, 2) lie in the picture, `margin` pixels away from its edge; (N,). nan is outside."""
        u, v = uv[:, 0], uv[:, 1]
        with np.errstate(invalid="ignore"):
            return (
                (u >= margin - 0.5)
                & (v >= margin - 0.5)
                & (u <= self.width - 0.5 - margin)
                & (v <= self.height - 0.5 - margin)
            )
