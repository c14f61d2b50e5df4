"""Bundle adjustment: camera poses and points in space together, so that every observation is met as well as can be.

Levenberg-Marquardt on the reprojection error; the points are eliminated (Schur complement), so that the system to be
solved has six unknowns for each frame. Robust weights (Cauchy) keep what does not belong from pulling.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass
class Scene:
    """rotations (F, 3, 3), translations (F, 3): camera_optical to world. points (P, 3) in the world.

    frame (N,), point (N,): which frame saw which point; seen (N, 2): where, on the plane z = 1 of the camera.
    """

    rotations: Points
    translations: Points
    points: Points
    frame: NDArray[np.intp]
    point: NDArray[np.intp]
    seen: Points

    def in_camera(self) -> Points:
        """The observed points (N, 3) in the frame of the camera that saw them."""
        relative = self.points[self.point] - self.translations[self.frame]
        local: Points = np.einsum("nji,nj->ni", self.rotations[self.frame], relative)
        return local

    def residuals(self) -> Points:
        """Observation minus projection (N, 2); far off for a point behind the camera."""
        local = self.in_camera()
        depth = np.where(local[:, 2] > 1e-6, local[:, 2], 1e-6)
        return self.seen - local[:, :2] / depth[:, None]


def adjust(scene: Scene, scale: float, iterations: int = 20, tolerance: float = 1e-4) -> Scene:
    """The scene with all poses and points improved; the first frame stays where it is.

    scale: residual (in units of `seen`) at which an observation begins to count less.
    """
    damping = 1e-4
    cost = _cost(scene, scale)
    pairs = _pairs(scene.point)
    for _ in range(iterations):
        step = _step(scene, scale, damping, pairs)
        moved = None if step is None else _move(scene, *step)
        new = np.inf if moved is None else _cost(moved, scale)
        if moved is None or not new < cost:
            damping *= 10.0
            if damping > 1e3:
                break
            continue
        done = cost - new < tolerance * cost
        scene, cost, damping = moved, new, max(damping / 5.0, 1e-9)
        if done:
            break
    return scene


def _cost(scene: Scene, scale: float) -> float:
    squared = (scene.residuals() ** 2).sum(axis=1) / scale**2
    return float(np.log1p(squared).sum())


def _jacobians(scene: Scene) -> tuple[Points, Points]:
    """Derivatives of the projection: (N, 2, 6) by a turn and shift in the camera's frame, (N, 2, 3) by the point."""
    local = scene.in_camera()
    depth = np.maximum(local[:, 2], 1e-6)
    u, v = local[:, 0] / depth, local[:, 1] / depth
    by_local = np.zeros((len(local), 2, 3))
    by_local[:, 0, 0] = by_local[:, 1, 1] = 1.0 / depth
    by_local[:, 0, 2], by_local[:, 1, 2] = -u / depth, -v / depth
    turned = np.zeros((len(local), 3, 3))  # of −[turn]× local, by the turn
    x, y, z = local.T
    turned[:, 0, 1], turned[:, 0, 2] = -z, y
    turned[:, 1, 0], turned[:, 1, 2] = z, -x
    turned[:, 2, 0], turned[:, 2, 1] = -y, x
    by_pose = np.concatenate((by_local @ turned, -by_local), axis=2)
    by_point = by_local @ scene.rotations[scene.frame].transpose(0, 2, 1)
    return by_pose, by_point


def _step(
    scene: Scene, scale: float, damping: float, pairs: tuple[NDArray[np.intp], NDArray[np.intp]]
) -> tuple[Points, Points] | None:
    frames, points = len(scene.rotations), len(scene.points)
    left = scene.residuals()
    weight = 1.0 / (1.0 + (left**2).sum(axis=1) / scale**2)
    by_pose, by_point = _jacobians(scene)
    weighted_pose, weighted_point = by_pose * weight[:, None, None], by_point * weight[:, None, None]
    pose_block = _summed(scene.frame, weighted_pose.transpose(0, 2, 1) @ by_pose, frames)
    pose_pull = _summed(scene.frame, np.einsum("nij,ni->nj", weighted_pose, left), frames)
    point_block = _summed(scene.point, weighted_point.transpose(0, 2, 1) @ by_point, points)
    point_pull = _summed(scene.point, np.einsum("nij,ni->nj", weighted_point, left), points)
    point_block += np.eye(3) * (damping * np.trace(point_block, axis1=1, axis2=2)[:, None, None] / 3 + 1e-12)
    inverse = np.linalg.inv(point_block)
    mixed = weighted_pose.transpose(0, 2, 1) @ by_point  # (N, 6, 3)
    reduced = mixed @ inverse[scene.point]  # (N, 6, 3)
    first, second = pairs
    product = reduced[first] @ mixed[second].transpose(0, 2, 1)
    between = _summed(scene.frame[first] * frames + scene.frame[second], product, frames * frames)
    system = -between.reshape(frames, frames, 6, 6)
    at = np.arange(frames)
    system[at, at] += pose_block * (1 + damping * np.eye(6))
    pull = pose_pull - _summed(scene.frame, np.einsum("nij,nj->ni", reduced, point_pull[scene.point]), frames)
    size = 6 * frames
    matrix = system.transpose(0, 2, 1, 3).reshape(size, size)[6:, 6:]
    try:
        pose_step = np.linalg.solve(matrix + 1e-12 * np.eye(size - 6), pull.ravel()[6:])
    except np.linalg.LinAlgError:
        return None
    pose_steps = np.concatenate((np.zeros(6), pose_step)).reshape(frames, 6)
    back = _summed(scene.point, np.einsum("nij,ni->nj", mixed, pose_steps[scene.frame]), points)
    return pose_steps, np.einsum("nij,nj->ni", inverse, point_pull - back)


def _pairs(point: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """All ordered pairs of observations of one point, also with themselves, as two index arrays."""
    order = np.argsort(point, kind="stable")
    ordered = point[order]
    first, second = [order], [order]
    gap = 1
    while gap < len(order):
        same = ordered[gap:] == ordered[:-gap]
        if not same.any():
            break
        first += [order[:-gap][same], order[gap:][same]]
        second += [order[gap:][same], order[:-gap][same]]
        gap += 1
    return np.concatenate(first), np.concatenate(second)


def _summed(group: NDArray[np.intp], values: Points, groups: int) -> Points:
    """Sums (groups, …) of the values (N, …) of each group; many times faster than `np.add.at`."""
    total = np.zeros((groups, *values.shape[1:]))
    if len(group):
        order = np.argsort(group, kind="stable")
        ordered = group[order]
        begins = np.flatnonzero(np.r_[True, ordered[1:] != ordered[:-1]])
        total[ordered[begins]] = np.add.reduceat(values[order], begins, axis=0)
    return total


def _move(scene: Scene, pose_steps: Points, point_steps: Points) -> Scene:
    """A turn and a shift of each camera in its own frame, a shift of each point."""
    turns = np.stack([cv2.Rodrigues(step[:3])[0] for step in pose_steps])
    shift = np.einsum("fij,fj->fi", scene.rotations, pose_steps[:, 3:])
    return Scene(
        scene.rotations @ turns,
        scene.translations + shift,
        scene.points + point_steps,
        scene.frame,
        scene.point,
        scene.seen,
    )
