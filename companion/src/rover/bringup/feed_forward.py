"""Feed-forward of a drive from runs by duty: duty = static + velocity · v + acceleration · dv/dt.

Integrated over a run from the moment in which the wheel begins to turn, so that no count is differentiated twice:
∫ duty dt = static · t + velocity · x(t) + acceleration · v(t), linear in all three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rover.bringup.bench import DUTY_PER_M_S, Run

# Seconds on both sides over which a speed is taken, and the slowest that counts as turning, m/s.
HALF_S, TURNING_M_S = 0.02, 0.02


@dataclass(frozen=True)
class FeedForward:
    """Duty of nominal voltage, per m/s and m/s²; sigma: of the three, from what is left over. dead_band: duty."""

    static: float
    velocity: float
    acceleration: float
    sigma: tuple[float, float, float]
    dead_band: float
    speed: float
    """Reached at full duty, m/s."""


def fit(runs: Sequence[Run], scales: tuple[float, float], track: float) -> FeedForward:
    """`scales`: metres a count, left and right. Raises ValueError when nothing has moved."""
    rows: list[list[float]] = []
    wanted: list[float] = []
    bands: list[float] = []
    for run in runs:
        for wheel in (0, 1):
            _add(run, wheel, scales[wheel], track, rows, wanted, bands)
    if len(rows) < 30:
        raise ValueError("the wheels have hardly turned")
    design, right = np.array(rows), np.array(wanted)
    solution, _, rank, _ = np.linalg.lstsq(design, right, rcond=None)
    if rank < 3:
        raise ValueError("the runs were too much alike")
    left_over = float(np.sum((design @ solution - right) ** 2)) / (len(right) - 3)
    # Neighbouring samples share their errors: of ten in a row one counts.
    covariance = 10.0 * left_over * np.linalg.inv(design.T @ design)
    static, velocity, acceleration = (float(value) for value in solution)
    spread = np.sqrt(np.diag(covariance))
    sigma = float(spread[0]), float(spread[1]), float(spread[2])
    return FeedForward(static, velocity, acceleration, sigma, float(np.median(bands)), (1.0 - static) / velocity)


def _add(
    run: Run,
    wheel: int,
    scale: float,
    track: float,
    rows: list[list[float]],
    wanted: list[float],
    bands: list[float],
) -> None:
    """The equations of one wheel in one run."""
    times = np.array([event.time for event in run.wheels])
    counts = np.array([(event.left_counts, event.right_counts)[wheel] for event in run.wheels], dtype=float)
    if len(times) < 20:
        return
    way = (counts - counts[0]) * scale
    sign = 1.0 if way[-1] >= 0.0 else -1.0
    way *= sign
    speed = (np.interp(times + HALF_S, times, way) - np.interp(times - HALF_S, times, way)) / (2.0 * HALF_S)
    states = [run.commanded(float(time)) for time in times]
    half = (0.5 if wheel else -0.5) * track
    asked = np.array([sign * (state.travel + half * state.heading) for state in states]) * DUTY_PER_M_S
    duty = np.array([sign * (state.speed + half * state.turn_rate) for state in states]) * DUTY_PER_M_S
    turning = np.flatnonzero(speed > TURNING_M_S)
    if len(turning) < 10:
        return
    begin, end = turning[0], turning[-1]
    # From the first count on: before it the wheel stood, whatever the duty.
    bands.append(float(duty[np.flatnonzero(way > 0.0)[0]]))
    for at in range(begin + 1, end):
        if duty[at] > 0.02:
            span = times[at] - times[begin]
            rows.append([span, way[at] - way[begin], speed[at] - speed[begin]])
            wanted.append(asked[at] - asked[begin])
