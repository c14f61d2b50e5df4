"""Both rolling radii and the track from straight runs and turns that somebody has measured, with their uncertainty.

After Borenstein and Feng's UMBmark, but as one least-squares problem: a straight run gives the mean radius by its
length and the difference by its turn, a turn on the spot gives the track.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Slip that a run may hold beside what the tape is off by, as a share of its way.
SLIP = 0.004


@dataclass(frozen=True)
class Rolled:
    """One run: counts of both wheels, way along (m; None for a turn on the spot) and change of heading (rad)."""

    counts: tuple[int, int]
    way: float | None
    heading: float
    way_sigma: float = 0.002
    heading_sigma: float = 0.005


@dataclass(frozen=True)
class Geometry:
    """Metres; sigma of left radius, right radius, track."""

    left_radius: float
    right_radius: float
    track: float
    sigma: tuple[float, float, float]


def fit(runs: Sequence[Rolled], counts_per_revolution: int, start: tuple[float, float, float]) -> Geometry:
    """`start`: radii and track to begin with. Raises ValueError when the runs do not tell all three."""
    values = np.array(start, dtype=float)
    for _ in range(20):
        residuals, jacobian = _equations(runs, counts_per_revolution, values)
        if np.linalg.matrix_rank(jacobian) < 3:
            raise ValueError("straight runs and turns are both needed")
        step = np.linalg.lstsq(jacobian, -residuals, rcond=None)[0]
        values = values + step
        if float(np.abs(step / values).max()) < 1e-10:
            break
    residuals, jacobian = _equations(runs, counts_per_revolution, values)
    spare = len(residuals) - 3
    # No better than the sigmas that were assumed, and worse when the runs contradict each other.
    scatter = max(1.0, float(residuals @ residuals) / spare) if spare > 0 else 1.0
    spread = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)) * scatter)
    left, right, track = (float(value) for value in values)
    return Geometry(left, right, track, (float(spread[0]), float(spread[1]), float(spread[2])))


def _equations(
    runs: Sequence[Rolled], counts_per_revolution: int, values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Weighted residuals (N,) and their derivatives (N, 3) by left radius, right radius, track."""
    left_radius, right_radius, track = values
    rows: list[list[float]] = []
    off: list[float] = []
    for run in runs:
        left, right = (2.0 * math.pi * count / counts_per_revolution for count in run.counts)
        slip = SLIP * 0.5 * (abs(left * left_radius) + abs(right * right_radius))
        sigma = math.hypot(run.heading_sigma, slip * math.sqrt(2.0) / track)
        turned = (right * right_radius - left * left_radius) / track
        off.append((turned - run.heading) / sigma)
        rows.append([-left / track / sigma, right / track / sigma, -turned / track / sigma])
        if run.way is not None:
            sigma = math.hypot(run.way_sigma, slip / math.sqrt(2.0))
            way = 0.5 * (left * left_radius + right * right_radius)
            off.append((way - run.way) / sigma)
            rows.append([0.5 * left / sigma, 0.5 * right / sigma, 0.0])
    return np.array(off), np.array(rows)
