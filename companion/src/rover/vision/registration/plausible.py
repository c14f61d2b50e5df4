"""What a homography between two pictures of a plane can look like, and how much they share by it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.homography import apply_homography

Points = NDArray[np.float64]


def overlap(homography: Points, shape_a: tuple[int, ...], shape_b: tuple[int, ...]) -> float:
    """Share of A's area that comes to lie inside B, from a grid of points."""
    x, y = np.meshgrid(np.linspace(0, shape_a[1], 21), np.linspace(0, shape_a[0], 21))
    there = apply_homography(homography, np.column_stack((x.ravel(), y.ravel())))
    return float(((there >= 0.0) & (there <= (shape_b[1], shape_b[0]))).all(axis=1).mean())


def impossible(homography: Points, shape_a: tuple[int, ...]) -> str:
    """Why no camera that looks at a plane can have made this homography; empty where one can."""
    corners = _corners(shape_a)
    if np.any(np.column_stack((corners, np.ones(4))) @ homography[2] / homography[2, 2] < 0.1):
        return "the horizon would lie in the picture"
    mapped = apply_homography(homography, corners)
    edges = np.roll(mapped, -1, axis=0) - mapped
    turns = edges[:, 0] * np.roll(edges, -1, axis=0)[:, 1] - edges[:, 1] * np.roll(edges, -1, axis=0)[:, 0]
    if np.any(turns <= 0.0):
        return "the picture would be folded or mirrored"
    area = abs(cv2.contourArea(mapped.astype(np.float32))) / (shape_a[0] * shape_a[1])
    if not 0.05 < area < 20.0:
        return "the picture would be scaled beyond reason"
    return ""


def astray(there: Points, back: Points, shape_a: tuple[int, ...]) -> float:
    """How far A's corners lie from where they were once they went to B and came back: the mean, pixels."""
    corners = _corners(shape_a)
    returned = apply_homography(back, apply_homography(there, corners))
    return float(np.linalg.norm(returned - corners, axis=1).mean())


def _corners(shape: tuple[int, ...]) -> Points:
    """(4, 2), around the picture."""
    height, width = shape[:2]
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
