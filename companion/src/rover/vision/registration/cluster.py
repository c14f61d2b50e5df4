"""DBSCAN on points of the plane: matched keypoints that stand alone are noise (section 3.1.4 of the paper)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

EPSILON_PX = 20.0
MIN_POINTS = 5
NOISE = -1


def dbscan(points: NDArray[np.float64], epsilon: float = EPSILON_PX, min_points: int = MIN_POINTS) -> NDArray[np.intp]:
    """Cluster number of every point (N, D), counted from 0 in the order of their first core point; -1 is noise.

    A core point has at least `min_points` points, itself included, within `epsilon`; clusters are connected core
    points and what lies within `epsilon` of them (a border point goes to the cluster found first). Memory N².
    """
    points = np.asarray(points, dtype=np.float64)
    labels = np.full(len(points), NOISE, dtype=np.intp)
    if len(points) == 0:
        return labels
    squared = np.zeros((len(points), len(points)))
    for axis in range(points.shape[1]):
        difference = points[:, None, axis] - points[None, :, axis]
        squared += difference * difference
    near = squared <= epsilon * epsilon
    core = near.sum(axis=1) >= min_points
    cluster = 0
    for seed in np.flatnonzero(core):
        if labels[seed] != NOISE:
            continue
        # Whole rings of neighbours at once: as many steps as the cluster is wide, not as it has points.
        ring = np.array([seed])
        labels[seed] = cluster
        while len(ring):
            reached = near[ring].any(axis=0) & (labels == NOISE)
            labels[reached] = cluster
            ring = np.flatnonzero(reached & core)
        cluster += 1
    return labels
