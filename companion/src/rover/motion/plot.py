"""A trajectory as a picture (SVG): the way beside the path it was made of, and speed, acceleration and heading in time.

Drawn from the quantised segments that are sent, evaluated as the firmware does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rover.motion.extrema import Driven
from rover.motion.segment import State, advance, after
from rover.motion.trajectory import Trajectory

Array = NDArray[np.float64]

WIDTH, MAP, PANEL, GAP, EDGE = 760, 420, 130, 46, 56
MOST_SAMPLES = 4000
INK, FAINT, LINE, TURN = "#222222", "#bbbbbb", "#1f6fb4", "#c44e28"


def states(trajectory: Trajectory) -> Array:
    """(M, 4): time, speed, acceleration, heading; the ends of every segment and about 50 a second between them."""
    period = max(0.02, trajectory.duration / MOST_SAMPLES)
    state, time, found = State(heading=trajectory.heading), 0.0, []
    for segment in trajectory.segments:
        duration = segment.duration_us * 1e-6
        for t in np.linspace(0.0, duration, 1 + math.ceil(duration / period)).tolist():
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            found.append((time + t, at.speed, at.acceleration, at.heading))
        state = after(state, segment)
        time += duration
    return np.array(found).reshape(-1, 4)


def svg(trajectory: Trajectory, driven: Driven, path: ArrayLike) -> str:
    """The picture. `path` (N, 2): the polyline; crosses mark where the rover turns on the spot."""
    line = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    rows = states(trajectory)
    height = 2 * EDGE + MAP + 3 * (PANEL + GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="sans-serif" '
        f'font-size="12" fill="{INK}">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
        *_map(line, driven, _stops(trajectory)),
    ]
    names = ("speed, m/s", "acceleration, m/s²", "heading, rad")
    for number, name in enumerate(names):
        top = EDGE + MAP + GAP + number * (PANEL + GAP)
        parts += _panel(rows[:, 0], rows[:, number + 1], name, top)
    parts.append(f'<text x="{WIDTH - EDGE}" y="{height - 20}" text-anchor="end">time, s</text>')
    return "\n".join([*parts, "</svg>", ""])


def _stops(trajectory: Trajectory) -> list[int]:
    """Numbers of the segments that end at rest."""
    return [number for number, segment in enumerate(trajectory.segments) if segment.rest]


def _map(line: Array, driven: Driven, stops: Sequence[int]) -> list[str]:
    points = np.concatenate([line, driven.points])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = min((WIDTH - 2 * EDGE) / max(high[0] - low[0], 1e-6), MAP / max(high[1] - low[1], 1e-6))
    left = EDGE + 0.5 * (WIDTH - 2 * EDGE - scale * (high[0] - low[0]))

    def onto(xy: Array) -> Array:
        return np.column_stack([left + scale * (xy[:, 0] - low[0]), EDGE + scale * (high[1] - xy[:, 1])])

    parts = [_polyline(onto(line), FAINT, 1.0), _polyline(onto(driven.points), LINE, 1.6)]
    for x, y in onto(driven.poses[[number + 1 for number in stops], :2]).tolist():
        parts.append(f'<path d="M{x - 4:.1f} {y - 4:.1f}l8 8m0 -8l-8 8" stroke="{TURN}" fill="none"/>')
    size = f"{high[0] - low[0]:.2f} m × {high[1] - low[1]:.2f} m"
    note = "grey: path, blue: driven, crosses: at rest"
    return [*parts, f'<text x="{EDGE}" y="{EDGE - 24}">{size}; {note}</text>']


def _panel(time: Array, values: Array, name: str, top: float) -> list[str]:
    low, high = float(values.min()), float(values.max())
    span = max(high - low, 1e-9)
    end = max(float(time[-1]), 1e-9)
    x = EDGE + (WIDTH - 2 * EDGE) * time / end
    y = top + PANEL * (high - values) / span
    return [
        f'<rect x="{EDGE}" y="{top}" width="{WIDTH - 2 * EDGE}" height="{PANEL}" fill="none" stroke="{FAINT}"/>',
        f'<text x="{EDGE}" y="{top - 6}">{name}</text>',
        f'<text x="{EDGE - 6}" y="{top + 10}" text-anchor="end">{high:.3g}</text>',
        f'<text x="{EDGE - 6}" y="{top + PANEL}" text-anchor="end">{low:.3g}</text>',
        f'<text x="{WIDTH - EDGE}" y="{top - 6}" text-anchor="end">{end:.2f}</text>',
        _polyline(np.column_stack([x, y]), LINE, 1.2),
    ]


def _polyline(points: Array, colour: str, width: float) -> str:
    listed = " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
    return f'<polyline points="{listed}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
