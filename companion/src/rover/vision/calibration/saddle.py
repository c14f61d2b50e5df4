"""A checkerboard's corner as a blurred saddle fitted to the pixels around it: steadier under noise than its gradients.

Where two edges cross, the picture is a + b·tanh(d1/s)·tanh(d2/s), with d1 and d2 the distances to the edges and s the
blur. All corners are fitted at once, each with its own place, edge directions, brightness, contrast and blur.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# Radius of the window as a share of the distance between corners: the next edge stays outside.
WINDOW_SHARE = 0.45

MAX_ROUNDS = 15
STEPS = np.array([1e-4, 1e-4, 1e-5, 1e-5, 1e-3, 1e-3, 1e-4])
# A fit that wanders off by more than this share of the distance is not believed; the corner stays where it was.
MAX_SHIFT_SHARE = 0.3


def refine_saddles(grey: NDArray[np.uint8], corners: Points, columns: int) -> Points:
    """The corners (N, 2) of a picture (H, W), in rows of `columns`, each moved onto its saddle."""
    grid = corners.reshape(-1, columns, 2)
    along, across = (np.asarray(np.gradient(grid, axis=axis)).reshape(-1, 2) for axis in (1, 0))
    spacing = float(min(np.linalg.norm(along, axis=1).min(), np.linalg.norm(across, axis=1).min()))
    pixels, inside = _windows(corners, max(2.0, WINDOW_SHARE * spacing), grey.shape)
    values = grey[pixels[..., 1], pixels[..., 0]].astype(np.float64)
    middle, contrast = values.mean(axis=1), values.std(axis=1)
    first, second = (np.arctan2(way[:, 1], way[:, 0]) for way in (along, across))
    sign = np.sign(((values - middle[:, None]) * _saddle(pixels, corners, first, second, 1.0) * inside).sum(axis=1))
    shape = np.column_stack(
        (corners, first, second, middle, np.where(sign == 0, 1, sign) * contrast, np.ones(len(corners)))
    )
    damping = np.full(len(shape), 1e-2)
    error = _error(pixels, values, inside, shape)
    for _ in range(MAX_ROUNDS):
        jacobian = np.stack(
            [(_error(pixels, values, inside, shape + step) - error) / step[i] for i, step in enumerate(np.diag(STEPS))],
            axis=2,
        )
        normal = np.einsum("npi,npj->nij", jacobian, jacobian)
        diagonal = np.einsum("nii->ni", normal) * damping[:, None] + 1e-9
        slope = np.einsum("npi,np->ni", jacobian, error)
        move = np.linalg.solve(normal + np.eye(7) * diagonal[:, None, :], slope[..., None])[..., 0]
        trial = shape - move
        trial[:, 6] = np.clip(trial[:, 6], 0.3, spacing)
        changed = _error(pixels, values, inside, trial)
        better = (changed**2).sum(axis=1) < (error**2).sum(axis=1)
        shape, error = np.where(better[:, None], trial, shape), np.where(better[:, None], changed, error)
        damping = np.where(better, damping * 0.3, damping * 10.0)
    moved = shape[:, :2]
    near = np.linalg.norm(moved - corners, axis=1) < MAX_SHIFT_SHARE * spacing
    return np.where(near[:, None], moved, corners)


def _windows(corners: Points, radius: float, shape: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Pixels (N, P, 2) around each corner, and which of them are in its circle and in the picture, (N, P)."""
    reach = int(np.ceil(radius))
    v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    pixels = np.rint(corners).astype(np.int64)[:, None, :] + np.column_stack((u.ravel(), v.ravel()))
    limits = np.array([shape[1] - 1, shape[0] - 1])
    inside = (pixels >= 0).all(axis=2) & (pixels <= limits).all(axis=2)
    inside &= np.linalg.norm(pixels - corners[:, None, :], axis=2) <= radius
    return np.clip(pixels, 0, limits), inside


def _saddle(pixels: NDArray[np.int64], at: Points, first: Points, second: Points, blur: Points | float) -> Points:
    offset = pixels - at[:, None, :]
    width = np.broadcast_to(blur, (len(at),))[:, None]
    edges = [
        np.tanh((offset[..., 1] * np.cos(angle)[:, None] - offset[..., 0] * np.sin(angle)[:, None]) / width)
        for angle in (first, second)
    ]
    model: Points = edges[0] * edges[1]
    return model


def _error(pixels: NDArray[np.int64], values: Points, inside: NDArray[np.bool_], shape: Points) -> Points:
    model = _saddle(pixels, shape[:, :2], shape[:, 2], shape[:, 3], shape[:, 6])
    return (shape[:, 4, None] + shape[:, 5, None] * model - values) * inside
