"""A trajectory as a plot: the driven path beside the path that was asked for, and speed, acceleration and turn rate.

Drawn from the quantised segments that are sent, evaluated as the firmware does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.chart import Line, Page, Text, ticks
from rover.motion.segment import State, advance, after
from rover.motion.trajectory.driven import Driven
from rover.motion.trajectory.plan import Trajectory

Array = NDArray[np.float64]

# Sizes on the page.
WIDTH, MAP_HEIGHT, PANEL_HEIGHT, GAP, LEFT, RIGHT, TOP = 860, 460, 120, 44, 76, 28, 96
# Most states that the profiles are drawn from; beyond that they are sampled more coarsely than at 50 Hz.
MAX_SAMPLES = 4000
INK, FAINT, GRID, ASKED, DRIVEN, STOP = "#222222", "#666666", "#e4e4e4", "#9a9a9a", "#1f6fb4", "#c44e28"


def states(trajectory: Trajectory) -> Array:
    """(M, 4): time, speed, acceleration, turn rate; the ends of every segment and about 50 a second between them."""
    period = max(0.02, trajectory.duration / MAX_SAMPLES)
    state, time, found = State(heading=trajectory.heading), 0.0, []
    for segment in trajectory.segments:
        duration = segment.duration_us * 1e-6
        for t in np.linspace(0.0, duration, 1 + math.ceil(duration / period)).tolist():
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            found.append((time + t, at.speed, at.acceleration, at.turn_rate))
        state = after(state, segment)
        time += duration
    return np.array(found).reshape(-1, 4)


def draw(trajectory: Trajectory, driven: Driven, path: ArrayLike) -> Page:
    """The plot. `path` (N, 2): the polyline asked for, metres; crosses mark where the rover stands still."""
    line = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    rows = states(trajectory)
    page = Page(WIDTH, TOP + MAP_HEIGHT + 3 * (PANEL_HEIGHT + GAP) + 2 * GAP)
    page.marks.append(Text(LEFT, 30, "Trajectory", INK, 20.0))
    stops = [number + 1 for number, segment in enumerate(trajectory.segments) if segment.rest]
    figures = f"{rows[-1, 0]:.2f} s, {len(trajectory.segments)} segments, {max(len(stops) - 1, 0)} stops on the way"
    page.marks.append(Text(LEFT, 50, figures, FAINT))
    _legend(page)
    _map(page, line, driven, driven.poses[stops, :2])
    for number, name in enumerate(("speed, m/s", "acceleration, m/s²", "turn rate, rad/s")):
        top = TOP + MAP_HEIGHT + (number + 1) * GAP + GAP / 2 + number * PANEL_HEIGHT
        _panel(page, rows[:, 0], rows[:, number + 1], name, top, last=number == 2)
    return page


def _legend(page: Page) -> None:
    y = 70.0
    page.marks += [
        Line(np.array([[LEFT, y], [LEFT + 34, y]]), ASKED, 1.2, 5.0),
        Text(LEFT + 42, y + 4, "path asked for", INK),
        Line(np.array([[LEFT + 160, y], [LEFT + 194, y]]), DRIVEN, 2.0),
        Text(LEFT + 202, y + 4, "driven", INK),
        Text(LEFT + 292, y + 4, "at rest", INK),
    ]
    page.cross(LEFT + 276, y, STOP)


def _map(page: Page, line: Array, driven: Driven, stops: Array) -> None:
    """Both paths to the same scale in x and y, metres."""
    points = np.concatenate([line, driven.points])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.04 * max(float((high - low).max()), 0.1)
    low, high = low - margin, high + margin
    wide, tall = WIDTH - LEFT - RIGHT, MAP_HEIGHT
    scale = min(wide / (high[0] - low[0]), tall / (high[1] - low[1]))
    spare = (np.array([wide, tall]) / scale - (high - low)) / 2.0
    low, high = low - spare, high + spare

    def onto(xy: Array) -> Array:
        return np.column_stack([LEFT + scale * (xy[:, 0] - low[0]), TOP + scale * (high[1] - xy[:, 1])])

    for x in ticks(low[0], high[0], 9):
        column = LEFT + scale * (x - low[0])
        page.marks.append(Line(np.array([[column, TOP], [column, TOP + tall]]), GRID))
        page.marks.append(Text(column, TOP + tall + 16, f"{x:g}" if abs(x) > 1e-12 else "0", FAINT, 11.0, "middle"))
    for y in ticks(low[1], high[1], 7):
        row = TOP + scale * (high[1] - y)
        page.marks.append(Line(np.array([[LEFT, row], [LEFT + wide, row]]), GRID))
        page.marks.append(Text(LEFT - 6, row + 4, f"{y:g}" if abs(y) > 1e-12 else "0", FAINT, 11.0, "end"))
    page.marks.append(Text(LEFT + wide / 2, TOP + tall + 32, "x, m", INK, 12.0, "middle"))
    page.marks.append(Text(24, TOP + tall / 2, "y, m", INK, 12.0, "middle", upright=True))
    page.marks.append(Line(onto(line), ASKED, 1.2, 5.0))
    page.marks.append(Line(onto(driven.points), DRIVEN, 2.0))
    for x, y in onto(stops).tolist():
        page.cross(x, y, STOP)
    page.rectangle(LEFT, TOP, wide, tall, FAINT)


def _panel(page: Page, time: Array, values: Array, name: str, top: float, last: bool) -> None:
    """One value over time; zero is always on the axis."""
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    margin = 0.08 * max(high - low, 1e-6)
    low, high = low - margin, high + margin
    end, wide = max(float(time[-1]), 1e-9), WIDTH - LEFT - RIGHT
    for value in ticks(low, high, 5):
        row = top + PANEL_HEIGHT * (high - value) / (high - low)
        page.marks.append(Line(np.array([[LEFT, row], [LEFT + wide, row]]), GRID))
        label = f"{value:g}" if abs(value) > 1e-12 else "0"
        page.marks.append(Text(LEFT - 6, row + 4, label, FAINT, 11.0, "end"))
    for second in ticks(0.0, end, 10):
        column = LEFT + wide * second / end
        page.marks.append(Line(np.array([[column, top], [column, top + PANEL_HEIGHT]]), GRID))
        if last:
            page.marks.append(Text(column, top + PANEL_HEIGHT + 16, f"{second:g}", FAINT, 11.0, "middle"))
    across = np.column_stack([LEFT + wide * time / end, top + PANEL_HEIGHT * (high - values) / (high - low)])
    page.marks.append(Line(across, DRIVEN, 1.4))
    page.rectangle(LEFT, top, wide, PANEL_HEIGHT, FAINT)
    page.marks.append(Text(LEFT, top - 6, name, INK))
    if last:
        page.marks.append(Text(LEFT + wide / 2, top + PANEL_HEIGHT + 32, "time, s", INK, 12.0, "middle"))
