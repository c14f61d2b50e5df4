"""The paper's camera, and how far its table 2 can be reproduced: `python -m tools.calibrate.table2`.

Table 2 maps four pixels to the ground, which is as many as a homography has freedom for: that one fits says nothing.
What can be checked is whether a camera with some K could have made it, and how far the printed K is from that.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.vision.camera.model import focal_from_fov

Array = NDArray[np.float64]

WIDTH, HEIGHT = 320, 240
FOV = math.radians(45.0), math.radians(34.0)
PRINTED_FOCAL = 0.16
PRINTED_ROTATION = np.array([-0.0330, 0.0230, 0.4769])
BOX = 33.5, 22.5
PIXELS = np.array([[176.0, 216.0], [100.0, 100.0], [150.0, 101.0], [283.0, 216.0]])
WORLD = np.array([[7.3357, 56.996], [62.636, 1.5007], [61.873, 38.197], [6.8322, 132.5]])


def printed_matrix(focal_x: float, focal_y: float) -> Array:
    """K (eq. 8) with the paper's centre."""
    return np.array([[focal_x, 0.0, WIDTH / 2], [0.0, focal_y, HEIGHT / 2], [0.0, 0.0, 1.0]])


def skewness(matrix: Array, to_pixels: Array) -> tuple[float, float]:
    """How far the homography is from one of a camera K: angle between its axes off 90° (degrees), ratio of lengths."""
    first, second = (np.linalg.inv(matrix) @ to_pixels)[:, :2].T
    lengths = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    angle = math.degrees(math.acos(float(first @ second) / (lengths[0] * lengths[1])))
    return angle - 90.0, lengths[0] / lengths[1]


def ground_of(matrix: Array, rotation: Array, scale: float, shift: Array) -> Array:
    """What the rotation alone, at one distance, makes of the pixels: rays cut with a plane that is fitted best."""
    rays = np.column_stack((PIXELS, np.ones(len(PIXELS)))) @ np.linalg.inv(matrix).T @ rotation
    ground: Array = scale * rays[:, :2] / rays[:, 2:] + shift
    return ground


def best_plane(matrix: Array, rotation: Array, swapped: bool) -> float:
    """RMS in the table's unit when distance and offset are free, axes swapped or not."""
    plain = ground_of(matrix, rotation, 1.0, np.zeros(2))
    wanted = WORLD[:, ::-1] if swapped else WORLD
    best = math.inf
    for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        own = plain * sign
        centred, target = own - own.mean(axis=0), wanted - wanted.mean(axis=0)
        scale = float((centred * target).sum() / (centred**2).sum())
        best = min(best, float(np.sqrt(((scale * centred - target) ** 2).sum(axis=1).mean())))
    return best


def main() -> None:
    """Prints every figure of docs/results/calibration.md."""
    fx, fy = focal_from_fov(WIDTH, FOV[0]), focal_from_fov(HEIGHT, FOV[1])
    print(f"equations 9 and 10: fx = {fx:.2f}, fy = {fy:.2f} px, K = [[{fx:.2f} 0 159.5] [0 {fy:.2f} 119.5] [0 0 1]]")
    print(f"a focal length of {PRINTED_FOCAL} px would mean an angle of view of "
          f"{math.degrees(2 * math.atan(WIDTH / 2 / PRINTED_FOCAL)):.2f}°")  # fmt: skip
    to_pixels, _ = cv2.findHomography(WORLD, PIXELS, 0)
    print("table 2 as a homography, X, Y to u, v (exact, four points):")
    print("\n".join("  " + " ".join(f"{value:11.6f}" for value in row) for row in to_pixels))
    design = np.column_stack((PIXELS, np.ones(4)))
    coefficients, *_ = np.linalg.lstsq(design, WORLD, rcond=None)
    misses = np.sqrt(((design @ coefficients - WORLD) ** 2).sum(axis=1).mean())
    print(f"as an affine map (2 equations left over): X = {coefficients[0, 0]:.4f} u {coefficients[1, 0]:+.4f} v "
          f"{coefficients[2, 0]:+.2f}, Y = {coefficients[0, 1]:.4f} u {coefficients[1, 1]:+.4f} v "
          f"{coefficients[2, 1]:+.2f}, RMS {misses:.2f}")  # fmt: skip
    across, down = float(np.linalg.norm(coefficients[0])), float(np.linalg.norm(coefficients[1]))
    print(f"its scales: {across:.4f} a pixel along u, {down:.4f} along v, {across / down:.3f} to 1; the box's sides: "
          f"{BOX[0] / BOX[1]:.3f} to 1; the box would be {BOX[0] / across:.1f} × {BOX[1] / down:.1f} px")  # fmt: skip
    for label, matrix in (("printed K", printed_matrix(PRINTED_FOCAL, PRINTED_FOCAL)),
                          ("K of eq. 9, 10", printed_matrix(fx, fy))):  # fmt: skip
        angle, ratio = skewness(matrix, np.asarray(to_pixels, np.float64))
        print(f"{label}: axes of the table's ground {angle:+.1f}° off a right angle, lengths {ratio:.3f} to 1")
        rotation = np.asarray(cv2.Rodrigues(PRINTED_ROTATION)[0], np.float64)
        errors = [best_plane(matrix, rotation, swapped) for swapped in (False, True)]
        print(
            f"  with the printed rotation and the best distance and offset: RMS {min(errors):.1f} of the table's unit"
        )


if __name__ == "__main__":
    main()
