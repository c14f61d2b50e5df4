"""A plan as a plot (figure 10 of the paper): map, tree, path, start and goals, in metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rover.chart import Area, Line, Page, Text, circle, ticks
from rover.errors import BadInput
from rover.planning.fields import CircleField, Field, GridField
from rover.planning.result import PlanResult

Array = NDArray[np.float64]
Edges = NDArray[np.float64]  # (N, 2, 2): both ends of each edge of the tree, metres
Point = tuple[float, float]

# Sizes on the page; the map takes the longer side.
MAP_SIDE, LEFT, RIGHT, TOP, BOTTOM = 640, 76, 28, 96, 52
# The page is at least as wide as the legend.
MIN_WIDTH = 620
INK, FAINT, GRID = "#222222", "#666666", "#e4e4e4"
OBSTACLE, TREE, PATH, START, GOAL = "#5b5b5b", "#9cc3e0", "#c44e28", "#2a8a3e", "#7a3fa0"
# A grid of more cells a side is drawn in squares of several cells.
MAX_CELLS = 1024
# The planner's own: tree extensions, length of a step as a share of the map's diagonal, goal bias.
TREE_EXTENSIONS, STEP_SHARE, GOAL_BIAS = 1000, 0.1, 0.3


def draw(
    field: Field,
    start: Point,
    goals: Sequence[Point],
    result: PlanResult,
    robot_radius: float,
    tree: Edges | None = None,
) -> Page:
    """The plot; goals carry their number as given. The ring around the start is as large as the robot."""
    left, bottom, right, top = field.bounds
    scale = MAP_SIDE / max(right - left, top - bottom)
    wide, tall = (right - left) * scale, (top - bottom) * scale
    page = Page(max(round(LEFT + wide + RIGHT), MIN_WIDTH), round(TOP + tall + BOTTOM))

    def onto(points: Array) -> Array:
        return np.column_stack([LEFT + scale * (points[:, 0] - left), TOP + scale * (top - points[:, 1])])

    def place(point: Point) -> tuple[float, float]:
        x, y = onto(np.array([point]))[0].tolist()
        return x, y

    _axes(page, field.bounds, scale)
    page.marks.append(Area([onto(outline) for outline in outlines(field)], OBSTACLE))
    page.marks += [Line(onto(edge), TREE, 0.8) for edge in (tree if tree is not None else ())]
    page.marks.append(Line(onto(result.path), PATH, 2.2))
    page.ring(*place(start), max(3.0, robot_radius * scale), START, 2.0)
    for number, goal in enumerate(goals, start=1):
        x, y = place(goal)
        page.cross(x, y, GOAL, 5.0)
        page.marks.append(Text(x + 8, y - 6, str(number), GOAL, 14.0))
    page.rectangle(LEFT, TOP, wide, tall, FAINT)
    _heading(page, result, robot_radius, with_tree=tree is not None)
    return page


def outlines(field: Field) -> list[Array]:
    """Polygons (N, 2) in metres that cover the obstacles of the map, cut at its bounds."""
    if isinstance(field, CircleField):
        low, high = np.zeros(2), np.array([field.width, field.height])
        return [np.clip(circle(x, y, radius), low, high) for x, y, radius in field.obstacles.tolist()]
    return _runs(field) if isinstance(field, GridField) else []


def tree_edges(field: Field, start: Point, goals: Sequence[Point], robot_radius: float, seed: int) -> Edges:
    """Figure 3's tree with the planner's own settings and seed, grown until it has met all goals or given up."""
    left, bottom, right, top = field.bounds
    nodes, parents, _, _ = field.native.multi_goal_tree(
        start,
        np.array(goals, dtype=np.float64).reshape(-1, 2),
        float(robot_radius),
        seed % 2**64,
        TREE_EXTENSIONS,
        STEP_SHARE * math.hypot(right - left, top - bottom),
        GOAL_BIAS,
    )
    pairs = [(nodes[parent], node) for node, parent in zip(nodes, parents, strict=True) if parent >= 0]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2, 2)


def check_name(path: Path) -> None:
    """Raises BadInput when the file's ending is no format of a plot."""
    if path.suffix.lower() not in (".svg", ".png"):
        raise BadInput(f"--plot {path}: the name must end in .svg or .png")


def save(page: Page, path: Path) -> None:
    """Writes SVG or PNG, by the file's ending. Raises BadInput."""
    check_name(path)
    try:
        path.write_bytes(page.png() if path.suffix.lower() == ".png" else page.svg().encode())
    except OSError as error:
        raise BadInput(f"--plot {path}: can't be written: {error.strerror or error}") from error


def _runs(field: GridField) -> list[Array]:
    """A rectangle for every run of blocked cells in a row; runs that repeat in the next rows are one rectangle."""
    step = math.ceil(max(field.blocked.shape) / MAX_CELLS)
    rows, columns = (-(-count // step) for count in field.blocked.shape)
    padded = np.zeros((rows * step, columns * step + 1), dtype=bool)
    padded[: field.blocked.shape[0], : field.blocked.shape[1]] = field.blocked
    coarse = np.asarray(padded[:, :-1].reshape(rows, step, columns, step).any(axis=(1, 3)))
    side = field.resolution * step
    _, _, right, top = field.bounds
    high = np.array([right, top])
    found: list[Array] = []
    open_runs: dict[tuple[int, int], int] = {}
    for row in range(rows + 1):
        runs: set[tuple[int, int]] = set()
        if row < rows:
            edges = np.flatnonzero(np.diff(np.concatenate([[0], coarse[row].astype(np.int8), [0]])))
            runs = {(int(first), int(last)) for first, last in edges.reshape(-1, 2)}
        for run in [run for run in open_runs if run not in runs]:
            first = open_runs.pop(run)
            corners = np.array([[run[0], first], [run[1], first], [run[1], row], [run[0], row]], dtype=np.float64)
            found.append(np.minimum(np.array(field.origin) + side * corners, high))
        for run in runs:
            open_runs.setdefault(run, row)
    return found


def _axes(page: Page, bounds: tuple[float, float, float, float], scale: float) -> None:
    left, bottom, right, top = bounds
    wide, tall = (right - left) * scale, (top - bottom) * scale
    for x in ticks(left, right, 9):
        column = LEFT + scale * (x - left)
        page.marks.append(Line(np.array([[column, TOP], [column, TOP + tall]]), GRID))
        page.marks.append(Text(column, TOP + tall + 16, _label(x), FAINT, 11.0, "middle"))
    for y in ticks(bottom, top, 9):
        row = TOP + scale * (top - y)
        page.marks.append(Line(np.array([[LEFT, row], [LEFT + wide, row]]), GRID))
        page.marks.append(Text(LEFT - 6, row + 4, _label(y), FAINT, 11.0, "end"))
    page.marks.append(Text(LEFT + wide / 2, TOP + tall + 34, "x, m", INK, 12.0, "middle"))
    page.marks.append(Text(24, TOP + tall / 2, "y, m", INK, 12.0, "middle", upright=True))


def _label(value: float) -> str:
    return f"{value:g}" if abs(value) > 1e-9 else "0"


def _heading(page: Page, result: PlanResult, robot_radius: float, *, with_tree: bool) -> None:
    """Title, figures and legend."""
    page.marks.append(Text(LEFT, 30, "Plan", INK, 20.0))
    outcome = f"{result.length:.2f} m" if result.ok else f"no path to {len(result.unreachable)} of the goals"
    figures = f"{result.algorithm}: {outcome}, {len(result.path)} points, robot's radius {robot_radius:g} m"
    page.marks.append(Text(LEFT, 50, figures, FAINT))
    y = 74.0
    page.marks += [
        Line(np.array([[LEFT, y], [LEFT + 28, y]]), PATH, 2.2),
        Text(LEFT + 34, y + 4, "path", INK),
        Text(LEFT + 106, y + 4, "start, the robot's size", INK),
        Text(LEFT + 266, y + 4, "goal", INK),
        Area([circle(LEFT + 322, y, 6.0)], OBSTACLE),
        Text(LEFT + 334, y + 4, "obstacle", INK),
    ]
    page.ring(LEFT + 92, y, 6.0, START)
    page.cross(LEFT + 254, y, GOAL, 5.0)
    if with_tree:
        page.marks.append(Line(np.array([[LEFT + 408, y], [LEFT + 436, y]]), TREE, 1.6))
        page.marks.append(Text(LEFT + 442, y + 4, "tree of figure 3", INK))
