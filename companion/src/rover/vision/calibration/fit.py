"""Least squares over one set of shared parameters and a pose for each view, with the covariance of what was found.

Levenberg-Marquardt with Jacobians by differences. A view's pose moves only the view's own points, so that all views
are differentiated at once; residuals beyond what the rest shows count less (Cauchy).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# (shared (S,), poses (V, 6)) to residuals (V, R) in pixels; a pose is a rotation vector and a translation.
Residuals = Callable[[Array, Array], Array]

STEP = 1e-6
MAX_ROUNDS = 60
CONVERGED = 1e-8
# In units of the residuals' own scatter.
CAUCHY = 3.0


@dataclass(frozen=True)
class Fit:
    """shared: (S,). poses: (V, 6). covariance: (S, S) of `shared`. residuals: (V, R) in pixels."""

    shared: Array
    poses: Array
    covariance: Array
    residuals: Array

    @property
    def rms(self) -> float:
        """Root of the mean squared distance between a point and where it should be, pixels (two residuals a point)."""
        return float(np.sqrt(2.0 * np.mean(self.residuals**2)))

    @property
    def view_rms(self) -> Array:
        """The same for each view, (V,)."""
        rms: Array = np.sqrt(2.0 * np.mean(self.residuals**2, axis=1))
        return rms


def fit(residuals: Residuals, shared: Array, poses: Array) -> Fit:
    """Minimises the residuals from a start that must be near. Without views (V = 0 poses) `poses` is (1, 0)."""
    damping = 1e-3
    current = residuals(shared, poses)
    for _ in range(MAX_ROUNDS):
        weights = _weights(current)
        jacobian = _jacobian(residuals, shared, poses)
        normal = _squared(jacobian, weights)
        gradient = jacobian.T @ (weights * current).ravel()
        cost = float((weights * current**2).sum())
        improved = False
        for _ in range(12):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), -gradient)
            new_shared = shared + step[: shared.size]
            new_poses = poses + step[shared.size :].reshape(poses.shape)
            trial = residuals(new_shared, new_poses)
            new_cost = float((weights * trial**2).sum())
            if np.isfinite(new_cost) and new_cost < cost:
                improved = True
                break
            damping *= 5.0
        if not improved:
            break
        shared, poses, current = new_shared, new_poses, trial
        damping = max(damping / 10.0, 1e-12)
        if cost - new_cost < CONVERGED * (1.0 + cost):
            break
    weights = _weights(current)
    jacobian = _jacobian(residuals, shared, poses)
    normal = _squared(jacobian, weights)
    freedom = max(1, current.size - normal.shape[0])
    variance = float((weights * current**2).sum()) / freedom
    covariance = variance * np.linalg.pinv(normal, hermitian=True, rcond=1e-15)
    return Fit(shared, poses, covariance[: shared.size, : shared.size], current)


def rigid(poses: Array, points: Array) -> Array:
    """Points (N, 3) moved by each pose (V, 6): (V, N, 3)."""
    rotations = np.stack([cv2.Rodrigues(pose[:3])[0] for pose in poses])
    moved: Array = np.einsum("vij,nj->vni", rotations, points) + poses[:, None, 3:]
    return moved


def _squared(jacobian: Array, weights: Array) -> Array:
    # Not through the BLAS: its threads cost more than these small products on a machine with other work.
    product: Array = np.einsum("ri,rj->ij", jacobian * weights.reshape(-1, 1), jacobian)
    return product


def _weights(residuals: Array) -> Array:
    size = np.abs(residuals)
    scale = max(CAUCHY * 1.4826 * float(np.median(size)), 1e-6)
    weights: Array = 1.0 / (1.0 + (size / scale) ** 2)
    return weights


def _jacobian(residuals: Residuals, shared: Array, poses: Array) -> Array:
    views, freedoms = poses.shape
    columns = []
    for index in range(shared.size):
        move = np.zeros(shared.size)
        move[index] = STEP * max(1.0, abs(shared[index]))
        change = residuals(shared + move, poses) - residuals(shared - move, poses)
        columns.append(change.ravel() / (2.0 * move[index]))
    per_view = residuals(shared, poses).shape[1]
    own = np.zeros((views, per_view, views, freedoms))
    for index in range(freedoms):
        move = np.zeros(freedoms)
        move[index] = STEP
        change = (residuals(shared, poses + move) - residuals(shared, poses - move)) / (2.0 * STEP)
        own[np.arange(views), :, np.arange(views), index] = change
    left = np.column_stack(columns) if columns else np.zeros((views * per_view, 0))
    return np.hstack((left, own.reshape(views * per_view, views * freedoms)))
