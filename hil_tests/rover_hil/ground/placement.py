"""Where things lie in a field: seeded rejection sampling under clearances that keep the field drivable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

# Centre to centre.
MIN_MINE_SPACING_M = 0.55
# Mine centre to obstacle edge.
MIN_MINE_TO_OBSTACLE_M = 0.40
MIN_MINE_TO_BORDER_M = 0.25
MIN_MINE_TO_LAUNCH_M = 0.60
MIN_MINE_TO_GOAL_M = 0.40
# Edge to edge.
MIN_OBSTACLE_GAP_M = 0.60
# Edge of the obstacle to the border, inside.
MIN_OBSTACLE_TO_BORDER_M = 0.10
LAUNCH_DISC_M = 0.45
MIN_GOAL_CLEARANCE_M = 0.25
# From the edge of bare ground to that of an obstacle, and to a mine's centre.
MIN_TO_BARE_M = 0.20
MIN_MINE_TO_BARE_M = 0.30
# Of the disc that must be able to go everywhere: the rover's 0.15 and what it keeps clear.
DISC_RADIUS_M = 0.25
MINE_KEEP_OUT_M = 0.15
MIN_CONNECTED_SHARE = 0.97
_MAX_LAYOUTS = 60
_MAX_DRAWS = 300

Circle = tuple[float, float, float]
Point = tuple[float, float]


@dataclass(frozen=True)
class Site:
    """What placement must respect: the area from (0, 0), the launch point, goals, known obstacles, bare ground."""

    width: float
    height: float
    launch: Point
    goals: tuple[Point, ...]
    known: tuple[Circle, ...]
    # Discs that nothing lies on: marker plates.
    bare: tuple[Circle, ...] = ()


@dataclass(frozen=True)
class Layout:
    """Placed circles (x, y, radius) in the order of the radii asked for, and mine centres."""

    obstacles: tuple[Circle, ...]
    mines: tuple[Point, ...]


def _distance(a: Sequence[float], b: Sequence[float]) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])


def obstacle_fits(site: Site, circle: Circle, others: Sequence[Circle], mines: Sequence[Point]) -> bool:
    """True when the obstacle keeps every clearance to what is already there."""
    x, y, r = circle
    border = r + MIN_OBSTACLE_TO_BORDER_M
    return (
        border <= x <= site.width - border
        and border <= y <= site.height - border
        and _distance(circle, site.launch) >= r + LAUNCH_DISC_M
        and all(_distance(circle, goal) >= r + MIN_GOAL_CLEARANCE_M for goal in site.goals)
        and all(_distance(circle, other) >= r + other[2] + MIN_OBSTACLE_GAP_M for other in others)
        and all(_distance(circle, mine) >= r + MIN_MINE_TO_OBSTACLE_M for mine in mines)
        and all(_distance(circle, other) >= r + other[2] + MIN_TO_BARE_M for other in site.bare)
    )


def mine_fits(site: Site, mine: Point, others: Sequence[Point], obstacles: Sequence[Circle]) -> bool:
    """True when the mine keeps every clearance to what is already there."""
    return (
        MIN_MINE_TO_BORDER_M <= mine[0] <= site.width - MIN_MINE_TO_BORDER_M
        and MIN_MINE_TO_BORDER_M <= mine[1] <= site.height - MIN_MINE_TO_BORDER_M
        and _distance(mine, site.launch) >= MIN_MINE_TO_LAUNCH_M
        and all(_distance(mine, goal) >= MIN_MINE_TO_GOAL_M for goal in site.goals)
        and all(_distance(mine, other) >= MIN_MINE_SPACING_M for other in others)
        and all(_distance(mine, obstacle) >= obstacle[2] + MIN_MINE_TO_OBSTACLE_M for obstacle in obstacles)
        and all(_distance(mine, other) >= other[2] + MIN_MINE_TO_BARE_M for other in site.bare)
    )


def is_connected(site: Site, obstacles: Sequence[Circle], mines: Sequence[Point], cell: float = 0.02) -> bool:
    """True when obstacles and mines cut nothing off that a disc could reach past the known obstacles alone.

    Nearly all of that ground, and every goal in it, must stay reachable from the launch point.
    """
    before, at_start = _reachable(site, site.known, cell)
    blocked = [*site.known, *obstacles, *((x, y, MINE_KEEP_OUT_M) for x, y in mines)]
    after, at_end = _reachable(site, blocked, cell)
    still_free = before & at_end
    if any(before[_cell_of(site, goal, cell)] and not after[_cell_of(site, goal, cell)] for goal in site.goals):
        return False
    enough = np.count_nonzero(after) >= MIN_CONNECTED_SHARE * np.count_nonzero(still_free)
    return bool(at_start.any() and enough)


def _reachable(site: Site, blocked: Sequence[Circle], cell: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Cells (rows, columns) where the disc may stand and that it can reach from the launch; where it may stand."""
    columns, rows = round(site.width / cell), round(site.height / cell)
    x = (np.arange(columns) + 0.5)[None, :] * cell
    y = (np.arange(rows) + 0.5)[:, None] * cell
    free = (x >= DISC_RADIUS_M) & (x <= site.width - DISC_RADIUS_M)
    free = free & (y >= DISC_RADIUS_M) & (y <= site.height - DISC_RADIUS_M)
    for cx, cy, r in blocked:
        reach = r + DISC_RADIUS_M
        window = (_span(cy, reach, cell, rows), _span(cx, reach, cell, columns))
        free[window] &= np.hypot(x[:, window[1]] - cx, y[window[0]] - cy) > reach
    # The rover stands at the launch point, however tight it is there.
    home = _cell_of(site, site.launch, cell)
    free[max(0, home[0] - 3) : home[0] + 4, max(0, home[1] - 3) : home[1] + 4] = True
    _, labels = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    return labels == labels[home], free


def _span(centre: float, reach: float, cell: float, count: int) -> slice:
    return slice(max(0, int((centre - reach) / cell)), min(count, max(0, int((centre + reach) / cell) + 1)))


def _cell_of(site: Site, point: Point, cell: float) -> tuple[int, int]:
    """Row and column of a point; one at the very border counts where the disc can first stand."""
    px = min(max(point[0], DISC_RADIUS_M + cell), site.width - DISC_RADIUS_M - cell)
    py = min(max(point[1], DISC_RADIUS_M + cell), site.height - DISC_RADIUS_M - cell)
    return int(py / cell), int(px / cell)


def check_known(site: Site) -> None:
    """Refuse goals or a launch point inside a known obstacle.

    Raises:
        BadInput: naming the goal and the obstacle.
    """
    for i, (x, y, r) in enumerate(site.known):
        for j, goal in enumerate(site.goals):
            if _distance(goal, (x, y)) < r:
                raise BadInput(f"mission.goals[{j}] {list(goal)} lies inside area.obstacles[{i}]: move the goal")
        if _distance(site.launch, (x, y)) < r:
            raise BadInput(f"launch point {list(site.launch)} lies inside area.obstacles[{i}]: move the launch")


def place(
    site: Site,
    obstacle_radii: Sequence[float],
    mines: int | Sequence[Point],
    rng: np.random.Generator,
) -> Layout:
    """Places for obstacles of the given radii and for mines (a count, or centres that are already fixed).

    Raises:
        BadInput: the field is too full for what was asked.
    """
    layout = try_place(site, obstacle_radii, mines, rng, layouts=_MAX_LAYOUTS)
    if layout is None:
        count = mines if isinstance(mines, int) else len(mines)
        raise BadInput(
            f"field: {len(obstacle_radii)} rocks and grass tufts and {count} mines do not fit into "
            f"{site.width:g} x {site.height:g} m with room to drive: ask for fewer or enlarge the area"
        )
    return layout


def try_place(
    site: Site,
    obstacle_radii: Sequence[float],
    mines: int | Sequence[Point],
    rng: np.random.Generator,
    layouts: int,
) -> Layout | None:
    """Like `place`, but None after `layouts` failed attempts."""
    for _ in range(layouts):
        layout = _draw_layout(site, obstacle_radii, mines, rng)
        if layout is not None and is_connected(site, (*site.known, *layout.obstacles), layout.mines):
            return layout
    return None


def _draw_layout(
    site: Site, radii: Sequence[float], mines: int | Sequence[Point], rng: np.random.Generator
) -> Layout | None:
    """One attempt: mines first (they are the harder to place), large obstacles before small ones."""
    centres: list[Point] = []
    if isinstance(mines, int):
        for _ in range(mines):
            for _ in range(_MAX_DRAWS):
                point = (float(rng.uniform(0, site.width)), float(rng.uniform(0, site.height)))
                if mine_fits(site, point, centres, site.known):
                    centres.append(point)
                    break
            else:
                return None
    else:
        centres = list(mines)

    placed: dict[int, Circle] = {}
    for index in sorted(range(len(radii)), key=lambda i: -radii[i]):
        taken = [*site.known, *placed.values()]
        for _ in range(_MAX_DRAWS):
            circle = (
                float(rng.uniform(0, site.width)),
                float(rng.uniform(0, site.height)),
                float(radii[index]),
            )
            if obstacle_fits(site, circle, taken, centres):
                placed[index] = circle
                break
        else:
            return None
    return Layout(tuple(placed[i] for i in range(len(radii))), tuple(centres))
