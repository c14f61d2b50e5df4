"""The families of maps on which plans without a budget are compared with grid A* and string pulling."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.planning import CircleField, Field, GridField

from tools.bench.planner.scenes import RADIUS, RESOLUTION, Point, random_scene, rasterise

Task = tuple[Point, Point]
Cells = NDArray[np.bool_]
MAPS = ("32room_002", "den312d", "maze512-8-0", "random512-15-3")
# Robot on grids of one metre a cell, as in docs/results/planning.md.
GRID_RADIUS = 1 / 3
GRID_SIDE = 400


@dataclass(frozen=True)
class Ground:
    """A map, the same as cells for the A*, and tasks on it; metres."""

    field: Field
    blocked: Cells
    resolution: float
    radius: float
    tasks: Sequence[Task]


def families(folder: Path | None, tasks: int, seeds: int) -> Iterator[tuple[str, list[Ground]]]:
    """Each family with its grounds; the shared maps only where their `folder` is given."""
    for name in MAPS if folder is not None else ():
        assert folder is not None
        yield name, [shared(folder, name, tasks)]
    yield "mazes", [grid(maze(6 + 2 * (seed % 3), seed), tasks, seed) for seed in range(seeds)]
    yield "rooms", [grid(rooms(20 + 6 * (seed % 3), seed), tasks, seed) for seed in range(seeds)]
    yield "random grids", [grid(scattered(0.1 + 0.05 * (seed % 3), seed), tasks, seed) for seed in range(seeds)]
    yield "few circles", [few_circles((8, 14, 30, 60)[seed % 4], tasks, seed) for seed in range(seeds)]
    yield "circles, 20 m", [many_circles(20.0, (0.2, 0.3, 0.4)[seed % 3], tasks, seed) for seed in range(seeds)]
    yield "circles, 40 m", [many_circles(40.0, 0.4, tasks, seed) for seed in range(max(seeds // 3, 1))]


def shared(folder: Path, name: str, tasks: int) -> Ground:
    """A MovingAI map with scenarios spread over its list."""
    field = GridField.load_movingai(folder / f"{name}.map")
    rows = [line.split("\t") for line in (folder / f"{name}.map.scen").read_text().splitlines()[1:] if line]
    chosen = rows[:: max(1, len(rows) // tasks)]
    ends = [tuple(int(cell) + 0.5 for cell in row[4:8]) for row in chosen]
    return Ground(field, field.blocked, 1.0, GRID_RADIUS, [((a, b), (c, d)) for a, b, c, d in ends])


def grid(blocked: Cells, tasks: int, seed: int) -> Ground:
    """Random tasks on a grid of one metre a cell."""
    field = GridField(blocked, 1.0)
    return Ground(field, blocked, 1.0, GRID_RADIUS, connected_tasks(field, GRID_RADIUS, tasks, seed))


def maze(width: int, seed: int) -> Cells:
    """Corridors of so many cells by depth-first search, with a few walls taken out."""
    rng = np.random.default_rng(seed)
    pitch = width + 1
    count = GRID_SIDE // pitch
    blocked = np.zeros((count * pitch + 1, count * pitch + 1), dtype=bool)
    blocked[::pitch] = blocked[:, ::pitch] = True
    seen, stack = {(0, 0)}, [(0, 0)]
    while stack:
        row, column = stack[-1]
        beside = [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
        open_to = [(r, c) for r, c in beside if 0 <= r < count and 0 <= c < count and (r, c) not in seen]
        if not open_to:
            stack.pop()
            continue
        to = open_to[int(rng.integers(len(open_to)))]
        open_wall(blocked, (row, column), to, pitch)
        seen.add(to)
        stack.append(to)
    for row, column in rng.integers(1, count, (count * count // 20, 2)):
        open_wall(blocked, (int(row) - 1, int(column)), (int(row), int(column)), pitch)
    return blocked


def open_wall(blocked: Cells, a: tuple[int, int], b: tuple[int, int], pitch: int) -> None:
    """Takes out the wall between two rooms of a maze that lie side by side."""
    row, column = max(a[0], b[0]) * pitch, max(a[1], b[1]) * pitch
    if a[0] == b[0]:
        blocked[row + 1 : row + pitch, column] = False
    else:
        blocked[row, column + 1 : column + pitch] = False


def rooms(side: int, seed: int) -> Cells:
    """Rooms of so many cells a side, three walls of four with a door of 2 to 4 cells."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((GRID_SIDE, GRID_SIDE), dtype=bool)
    blocked[::side] = blocked[:, ::side] = True
    for row in range(0, GRID_SIDE, side):
        for column in range(0, GRID_SIDE, side):
            doors = rng.integers(2, side - 4, 2)
            widths = rng.integers(2, 5, 2)
            if row > 0 and rng.random() < 0.75:
                blocked[row, column + doors[0] : column + doors[0] + widths[0]] = False
            if column > 0 and rng.random() < 0.75:
                blocked[row + doors[1] : row + doors[1] + widths[1], column] = False
    blocked[0] = blocked[-1] = blocked[:, 0] = blocked[:, -1] = True
    return blocked


def scattered(share: float, seed: int) -> Cells:
    """Single blocked cells."""
    return np.asarray(np.random.default_rng(seed).random((GRID_SIDE, GRID_SIDE)) < share, dtype=np.bool_)


def few_circles(count: int, tasks: int, seed: int) -> Ground:
    """6 × 6 m with circles of 0.1 to 0.45 m; tasks where the cells leave a way for a robot a little larger."""
    rng = np.random.default_rng(1000 + seed)
    circles = np.column_stack([rng.uniform(0.0, 6.0, (count, 2)), rng.uniform(0.1, 0.45, count)])
    blocked = rasterise(6.0, circles)
    found = connected_tasks(GridField(blocked, RESOLUTION), RADIUS + RESOLUTION, tasks, seed)
    return Ground(CircleField(6.0, 6.0, circles.tolist()), blocked, RESOLUTION, RADIUS, found)


def many_circles(size: float, share: float, tasks: int, seed: int) -> Ground:
    """Circles of 0.2 to 0.8 m that block a share of the ground."""
    scene = random_scene(size, 2 * tasks - 1, 2000 + seed, share)
    stops = [scene.start, *scene.goals]
    pairs = list(zip(stops[::2], stops[1::2], strict=True))
    return Ground(scene.circle_field(), scene.blocked, RESOLUTION, RADIUS, pairs)


def connected_tasks(field: GridField, radius: float, tasks: int, seed: int) -> list[Task]:
    """Random pairs of cells' centres in the largest piece of ground on which the robot fits."""
    free = np.argwhere(~field.blocked)
    centres = (free[:, ::-1] + 0.5) * field.resolution
    fits = np.zeros(field.blocked.shape, dtype=np.uint8)
    roomy = free[field.clearance(centres) >= radius]
    fits[roomy[:, 0], roomy[:, 1]] = 1
    _, labels, figures, _ = cv2.connectedComponentsWithStats(fits, connectivity=4)
    piece = np.argwhere(labels == 1 + int(np.argmax(figures[1:, cv2.CC_STAT_AREA])))
    chosen = piece[np.random.default_rng(seed).choice(len(piece), 2 * tasks)]
    points = [((float(c) + 0.5) * field.resolution, (float(r) + 0.5) * field.resolution) for r, c in chosen]
    return list(zip(points[::2], points[1::2], strict=True))
