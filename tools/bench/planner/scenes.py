"""The grounds that planners are compared on: the paper's field, and random fields with a given share blocked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.planning import CircleField, GridField
from rover.vehicle import STANDARD

Point = tuple[float, float]

# The paper's field of section 4.4 as the project fixes it.
PAPER_OBSTACLES = (
    (2.0, 1.5, 0.20),
    (1.3, 1.1, 0.15),
    (0.6, 0.7, 0.15),
    (2.6, 1.9, 0.15),
    (0.8, 1.8, 0.20),
    (1.5, 2.0, 0.15),
    (2.5, 3.1, 0.20),
    (1.6, 3.0, 0.18),
    (0.7, 2.9, 0.20),
    (0.4, 3.6, 0.10),
)
PAPER_START: Point = (2.0, 0.5)
PAPER_GOALS: tuple[Point, ...] = ((2.0, 2.5), (1.2, 3.5))
# Visibility graph over 48-sided circles.
PAPER_OPTIMUM = 3.580
RADIUS = STANDARD.radius
RESOLUTION = 0.05


@dataclass(frozen=True)
class Scene:
    """A field of circles, the same ground as cells (every cell that a circle touches is blocked), and a task."""

    size: float
    circles: NDArray[np.float64]  # (N, 3) x, y, radius
    blocked: NDArray[np.bool_]
    start: Point
    goals: list[Point]

    def circle_field(self) -> CircleField:
        return CircleField(self.size, self.size, self.circles.tolist())

    def grid_field(self) -> GridField:
        return GridField(self.blocked, RESOLUTION)


def paper_field() -> CircleField:
    """3 × 4 m, ten circles."""
    return CircleField(3.0, 4.0, PAPER_OBSTACLES)


def rasterise(size: float, circles: NDArray[np.float64], resolution: float = RESOLUTION) -> NDArray[np.bool_]:
    """Cells that a circle touches, (rows, columns)."""
    count = round(size / resolution)
    edges = np.arange(count) * resolution
    blocked = np.zeros((count, count), dtype=bool)
    for x, y, radius in circles:
        columns = slice(max(int((x - radius) / resolution) - 1, 0), int((x + radius) / resolution) + 2)
        rows = slice(max(int((y - radius) / resolution) - 1, 0), int((y + radius) / resolution) + 2)
        dx = np.maximum(np.maximum(edges[columns] - x, x - edges[columns] - resolution), 0.0)
        dy = np.maximum(np.maximum(edges[rows] - y, y - edges[rows] - resolution), 0.0)
        blocked[rows, columns] |= dx[None, :] ** 2 + dy[:, None] ** 2 <= radius**2
    return blocked


def random_scene(size: float, goals: int, seed: int, share: float = 0.4) -> Scene:
    """Circles of 0.2 to 0.8 m, overlapping as they fall, until `share` of the ground is blocked.

    Start and goals lie in the largest connected piece of ground with room for the robot's radius and a cell.
    """
    rng = np.random.default_rng(seed)
    chosen: list[NDArray[np.float64]] = []
    covered = 0.0
    while covered < share:
        batch = np.column_stack([rng.uniform(0.0, size, (40, 2)), rng.uniform(0.2, 0.8, 40)])
        chosen.append(batch)
        covered = float(rasterise(size, np.concatenate(chosen)).mean())
    circles = np.concatenate(chosen)
    blocked = rasterise(size, circles)
    field = GridField(blocked, RESOLUTION)
    count = blocked.shape[0]
    centres = (np.arange(count) + 0.5) * RESOLUTION
    grid = np.stack(np.meshgrid(centres, centres), axis=-1).reshape(-1, 2)
    roomy = (field.clearance(grid) >= RADIUS + RESOLUTION).reshape(count, count)
    cells = np.argwhere(_largest_piece(roomy))
    points = [tuple((cell[::-1] + 0.5) * RESOLUTION) for cell in cells[rng.choice(len(cells), goals + 1, False)]]
    start, *rest = [(float(x), float(y)) for x, y in points]
    return Scene(size, circles, blocked, start, rest)


def change(scene: Scene, share: float, seed: int) -> NDArray[np.bool_]:
    """`scene.blocked` with `share` of all cells flipped, half of them to blocked: patches of 0.2 to 1 m.

    The start's and the goals' own ground stays free.
    """
    rng = np.random.default_rng(seed)
    blocked: NDArray[np.bool_] = scene.blocked.copy()
    count = blocked.shape[0]
    wanted = round(share * blocked.size / 2)
    keep = np.zeros_like(blocked)
    reach = round((RADIUS + 2 * RESOLUTION) / RESOLUTION)
    for x, y in (scene.start, *scene.goals):
        column, row = int(x / RESOLUTION), int(y / RESOLUTION)
        keep[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1] = True
    for value in (True, False):
        left = wanted
        while left > 0:
            side = int(rng.integers(4, 21))
            row, column = rng.integers(0, count - side, 2)
            patch = (slice(row, row + side), slice(column, column + side))
            flips = np.flatnonzero((scene.blocked[patch] == blocked[patch]) & (blocked[patch] != value) & ~keep[patch])
            view = blocked[patch].copy().ravel()
            view[flips[:left]] = value
            blocked[patch] = view.reshape(side, side)
            left -= min(left, len(flips))
    return blocked


def _largest_piece(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The largest 4-connected piece of `free`."""
    import cv2

    _, labels, figures, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    return np.asarray(labels == 1 + int(np.argmax(figures[1:, cv2.CC_STAT_AREA])), dtype=np.bool_)
