"""Where things lie in a field that nobody has tidied up: in clusters, in lanes, beside each other and beside walls.

Nothing is promised but that no two things are in one place and that the rover can stand at its launch: ground may be
cut off, gaps may be too narrow, mines may lie against a rock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from rover.errors import BadInput

from rover_hil.ground.placement import Circle, Layout, Point, Site

# Edge of an obstacle and centre of a mine to the launch: the rover stands there, on ground that was surveyed by hand.
OBSTACLE_TO_LAUNCH_M = 0.20
MINE_TO_LAUNCH_M = 0.45
# Half the size of a mine, which may lie against a rock, but not under it.
MINE_M = 0.06
# Mines that touch set each other off: edge to edge.
MINE_GAP_M = 0.03
# Spread of a cluster, and of mines about the line of their lane, m.
CLUSTER_M = 0.35
LANE_M = 0.05
LANE_PITCH_M = 0.40
DRAWS = 4000

Draw = Callable[[], Point]


def place_at_random(site: Site, radii: Sequence[float], mines: int, rng: np.random.Generator) -> Layout:
    """Places for obstacles of these radii and for so many mines. Raises BadInput where there is no room at all."""
    launch = site.launch
    obstacles: list[Circle] = list(site.known)
    where = _patterns(site, obstacles, rng)
    placed: dict[int, Circle] = {}
    for index in sorted(range(len(radii)), key=lambda i: -radii[i]):
        r = radii[index]

        def fits(point: Point, r: float = r) -> bool:
            return (
                r <= point[0] <= site.width - r
                and r <= point[1] <= site.height - r
                and math.dist(point, launch) >= r + OBSTACLE_TO_LAUNCH_M
                and all(math.dist(point, goal) >= r for goal in site.goals)
                and all(math.dist(point, other[:2]) >= r + other[2] for other in obstacles)
            )

        x, y = _draw(where[:2], fits, rng, f"{len(radii)} rocks and grass tufts", site)
        placed[index] = (x, y, r)
        obstacles.append(placed[index])
    centres: list[Point] = []

    def free(point: Point) -> bool:
        return (
            MINE_M <= point[0] <= site.width - MINE_M
            and MINE_M <= point[1] <= site.height - MINE_M
            and math.dist(point, launch) >= MINE_TO_LAUNCH_M
            and all(math.dist(point, other[:2]) >= other[2] + MINE_M for other in obstacles)
            and all(math.dist(point, other) >= 2.0 * MINE_M + MINE_GAP_M for other in centres)
        )

    for _ in range(mines):
        centres.append(_draw(where, free, rng, f"{mines} mines", site))
    return Layout(tuple(placed[index] for index in range(len(radii))), tuple(centres))


def _patterns(site: Site, obstacles: list[Circle], rng: np.random.Generator) -> tuple[Draw, ...]:
    """Ways to draw a place: anywhere, in a cluster; and for mines alone in a lane, beside an obstacle or a wall."""

    def anywhere() -> Point:
        return float(rng.uniform(0.0, site.width)), float(rng.uniform(0.0, site.height))

    clusters = [anywhere() for _ in range(max(1, round(site.width * site.height / 5.0)))]
    lane, heading = anywhere(), float(rng.uniform(0.0, math.pi))
    span = math.ceil(math.hypot(site.width, site.height) / LANE_PITCH_M)

    def cluster() -> Point:
        x, y = clusters[int(rng.integers(len(clusters)))]
        return x + float(rng.normal(0.0, CLUSTER_M)), y + float(rng.normal(0.0, CLUSTER_M))

    def in_lane() -> Point:
        along = LANE_PITCH_M * int(rng.integers(-span, span + 1)) + float(rng.normal(0.0, LANE_M))
        across = float(rng.normal(0.0, LANE_M))
        cosine, sine = math.cos(heading), math.sin(heading)
        return lane[0] + along * cosine - across * sine, lane[1] + along * sine + across * cosine

    def beside() -> Point:
        x, y = anywhere()
        if obstacles and rng.random() < 0.7:
            ox, oy, r = obstacles[int(rng.integers(len(obstacles)))]
            bearing, away = rng.uniform(0.0, 2.0 * math.pi), r + MINE_M + rng.uniform(0.0, 0.08)
            return float(ox + away * math.cos(bearing)), float(oy + away * math.sin(bearing))
        edge = MINE_M + float(rng.uniform(0.0, 0.08))
        sides = ((edge, y), (site.width - edge, y), (x, edge), (x, site.height - edge))
        return sides[int(rng.integers(4))]

    return anywhere, cluster, in_lane, beside


def _draw(
    ways: Sequence[Draw], fits: Callable[[Point], bool], rng: np.random.Generator, what: str, site: Site
) -> Point:
    way = ways[int(rng.integers(len(ways)))]
    for attempt in range(DRAWS):
        point = (way if attempt < DRAWS // 20 else ways[0])()
        if fits(point):
            return point
    raise BadInput(f"field: {what} do not fit into {site.width:g} x {site.height:g} m even at random: ask for fewer")
