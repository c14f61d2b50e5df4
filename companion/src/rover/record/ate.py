"""How far an estimated trajectory lies from the true one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput


def absolute_trajectory_error(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the position error in metres over the times of `estimate` that `truth` covers.

    Both (N, ≥3): time, x, y, …, times ascending. Truth is interpolated linearly to the estimate's times. Both are in
    the map frame and start at the known launch pose, so nothing is aligned: an alignment would hide the drift.
    Raises BadInput when the two do not overlap in time.
    """
    times = estimate[:, 0]
    inside = (times >= truth[0, 0]) & (times <= truth[-1, 0]) if len(truth) else np.zeros(len(times), dtype=bool)
    if not inside.any():
        raise BadInput("the trajectories do not overlap in time")
    x = np.interp(times[inside], truth[:, 0], truth[:, 1])
    y = np.interp(times[inside], truth[:, 0], truth[:, 2])
    squared = (estimate[inside, 1] - x) ** 2 + (estimate[inside, 2] - y) ** 2
    return float(math.sqrt(np.mean(squared)))
