"""What the second look finds of mines at all depths, and how many spots bare ground has: on an ideal mosaic.

    python -m tools.evaluate.second_look --first 8201 --fields 100

Each field is the demo mission's with another seed. The mosaic is the ground's own temperature, mean of each cell, with
what noise many frames leave: neither optics nor an error of the pose blur it.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from rover.detection.second_look import likeness, peaks, sign_at
from rover.mission.caution import BOLD, CAUTIOUS
from rover.mission.config import load
from rover_hil.ground import build
from rover_hil.ground.field import Ground

from tools.evaluate.figures import binomial, poisson, table

CELL_M = 0.02
# Of a mean over some ten frames of 50 mK, kelvin.
NOISE_K = 0.015
# A spot this near to a mine's centre is the mine's, metres; this near to an obstacle's edge it is none of bare ground.
AT_MINE_M, AT_OBSTACLE_M = 0.06, 0.15


def mosaic(ground: Ground, rng: np.random.Generator) -> NDArray[np.float32]:
    """The area in cells of CELL_M, kelvin; obstacles are left out, as a mission leaves them."""
    size = round(CELL_M / ground.resolution)
    first = round(-ground.origin_x / ground.resolution)
    columns, rows = (round(length / CELL_M) for length in ground.area)
    part = ground.temperature[first : first + rows * size, first : first + columns * size]
    kelvin = part.reshape(rows, size, columns, size).mean(axis=(1, 3))
    y, x = (np.mgrid[:rows, :columns] + 0.5) * CELL_M
    for ox, oy, radius, _ in ground.obstacles.tolist():
        kelvin[np.hypot(x - ox, y - oy) < radius + CELL_M] = np.nan
    return np.asarray(kelvin + rng.normal(0.0, NOISE_K, kelvin.shape), np.float32)


def measure(first: int, fields: int) -> tuple[dict[float, list[float]], NDArray[np.float64], float]:
    """Likeness at every mine by its depth, that of every spot of bare ground, and the area in m²."""
    mission = load("demo")
    mines: dict[float, list[float]] = {}
    bare: list[NDArray[np.float64]] = []
    sign = sign_at(mission.time_of_day_s / 3600.0)
    for seed in range(first, first + fields):
        ground = build(mission, seed)
        found = peaks(likeness(mosaic(ground, np.random.default_rng(seed)), CELL_M, sign), CELL_M, 1.0)
        free = np.ones(len(found), bool)
        for mine in ground.mines:
            away = np.hypot(found[:, 0] - mine.x, found[:, 1] - mine.y)
            near = found[away < AT_MINE_M, 2]
            mines.setdefault(mine.depth, []).append(float(near.max(initial=0.0)))
            free &= away > 2.0 * AT_MINE_M
        for x, y, radius, _ in ground.obstacles.tolist():
            free &= np.hypot(found[:, 0] - x, found[:, 1] - y) > radius + AT_OBSTACLE_M
        bare.append(found[free, 2])
    return mines, np.concatenate(bare), fields * mission.area.width * mission.area.height


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(prog="python -m tools.evaluate.second_look", description=__doc__)
    parser.add_argument("--first", type=int, default=8201)
    parser.add_argument("--fields", type=int, default=100)
    options = parser.parse_args()
    mines, bare, area = measure(options.first, options.fields)
    depths = sorted(mines)
    named = ("surface" if depth == 0.0 else f"{100 * depth:g} cm" for depth in depths)
    head = ["kept off from", *named, "spots per m²"]
    rows = [
        [
            f"{least:g} σ",
            *(binomial(sum(z >= least for z in mines[depth]), len(mines[depth])) for depth in depths),
            poisson(int((bare >= least).sum()), area),
        ]
        for least in (2.0, CAUTIOUS, 3.0, BOLD, 4.0)
    ]
    print(table(head, rows))
    weakest = depths[-1]
    print(f"\nmedian at {100 * weakest:g} cm: {np.median(mines[weakest]):.1f} σ")


if __name__ == "__main__":
    main()
