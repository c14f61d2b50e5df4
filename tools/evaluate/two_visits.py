"""What a second survey at another hour adds: mines found by one hour's temperatures and by both together.

    python -m tools.evaluate.two_visits --fields 40

Synthetic mosaics, no drives: ground that differs from place to place in albedo, conductivity and heat capacity, what
each of these does at every hour from the heat model, a change between the visits, the camera's noise, and mines by the
same model. Thresholds are set on other fields, each for the same false spots per m²; then mines are counted.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rover.detection.second_look import likeness, peaks, sign_at
from rover.detection.two_visits import compare
from rover_hil.campaign.intervals import binomial_interval
from rover_hil.ground.heat import Case, simulate
from rover_hil.ground.raster import Grid
from rover_hil.ground.season import Season
from rover_hil.ground.signature import mine_case
from rover_hil.ground.soils import soil_named
from rover_hil.ground.texture import SOIL_SCALES, sum_of_scales
from rover_hil.outlook import ALBEDO, BETWEEN_VISITS_K, CONDUCTIVITY, HEAT_CAPACITY

from tools.evaluate.figures import table

SIDE_M, RESOLUTION = 4.0, 0.02
DEPTHS = (0.01, 0.03, 0.05, 0.07)
SOILS = ("loam", "clay", "moist-clay")
# Of the mosaic, after many frames, kelvin.
NOISE_K = 0.03
# A spot so near to a mine's middle is that mine, metres.
WITHIN_M = 0.10
FALSE_PER_M2 = (0.02, 0.05, 0.10)
# Of what the ground's causes and the visits' change look like over the ground.
_TEXTURE_K = float(np.sqrt(sum(rms**2 for _, rms in SOIL_SCALES)))

Spots = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Field:
    """mines (M, 3): x, y, depth. spots: of the first hour alone, of the second, and of both, each (N, 3)."""

    mines: Spots
    spots: tuple[Spots, Spots, Spots]


def make_field(seed: int, hours: tuple[float, float], season: Season) -> Field:
    """One field of SIDE_M with eight mines, surveyed at both hours; everything follows from the seed."""
    rng = np.random.default_rng([2020, seed])
    soil = soil_named(SOILS[seed % len(SOILS)])
    varied = (
        replace(soil, albedo=soil.albedo + ALBEDO),
        replace(soil, conductivity=soil.conductivity * (1.0 + CONDUCTIVITY)),
        replace(soil, heat_capacity=soil.heat_capacity * (1.0 + HEAT_CAPACITY)),
    )
    history = simulate([Case(soil), *map(Case, varied), *(mine_case(soil, depth) for depth in DEPTHS)], season)
    side = round(SIDE_M / RESOLUTION)
    grid = Grid(0.0, 0.0, RESOLUTION, side, side)
    causes = [sum_of_scales(grid, SOIL_SCALES, rng) / np.float32(_TEXTURE_K) for _ in varied]
    mines = _places(rng)
    kelvin = []
    for hour in hours:
        at = history.at(hour)
        ground = np.full(grid.shape, at[0, 0], np.float32)
        for number, cause in enumerate(causes, 1):
            ground += cause * np.float32(at[number, 0] - at[0, 0])
        ground += sum_of_scales(grid, SOIL_SCALES, rng) * np.float32(BETWEEN_VISITS_K / _TEXTURE_K)
        y, x = ((np.mgrid[0:side, 0:side] + 0.5) * RESOLUTION).astype(np.float32)
        for mx, my, depth in mines.tolist():
            profile = at[1 + len(varied) + DEPTHS.index(depth)] - at[0]
            ground += np.interp(np.hypot(x - mx, y - my), history.radius, profile - profile[-1]).astype(np.float32)
        kelvin.append(ground + NOISE_K * rng.standard_normal(grid.shape).astype(np.float32))
    alone = [peaks(likeness(k, RESOLUTION, sign_at(h)), RESOLUTION, 1.5) for k, h in zip(kelvin, hours, strict=True)]
    both = compare(kelvin[0], kelvin[1], hours, RESOLUTION).spots(1.5)
    return Field(mines, (alone[0], alone[1], both))


def _places(rng: np.random.Generator) -> Spots:
    """Two mines of each depth, at least 0.6 m apart and 0.3 m within the border."""
    found: list[list[float]] = []
    while len(found) < 2 * len(DEPTHS):
        x, y = rng.uniform(0.3, SIDE_M - 0.3, 2).tolist()
        if all(np.hypot(x - a, y - b) >= 0.6 for a, b, _ in found):
            found.append([x, y, DEPTHS[len(found) % len(DEPTHS)]])
    return np.array(found)


def sort_out(field: Field, way: int) -> tuple[Spots, Spots]:
    """Likeness of each mine's best spot (M,), 0 where there is none, and of the spots that are no mine's."""
    spots, mines = field.spots[way], field.mines
    if not len(spots):
        return np.zeros(len(mines)), np.zeros(0)
    apart = np.hypot(spots[:, None, 0] - mines[None, :, 0], spots[:, None, 1] - mines[None, :, 1])
    best = np.where(apart <= WITHIN_M, spots[:, None, 2], 0.0).max(axis=0)
    return best, spots[apart.min(axis=1) > WITHIN_M, 2]


def report(fields: int, first_seed: int, hours: tuple[float, float], season: Season) -> str:
    """Markdown: thresholds from `fields` fields, mines found on as many others."""
    chosen = [make_field(first_seed + k, hours, season) for k in range(fields)]
    tested = [make_field(first_seed + 10_000 + k, hours, season) for k in range(fields)]
    names = (f"{_clock(hours[0])} alone", f"{_clock(hours[1])} alone", "both")
    lines = []
    for wanted in FALSE_PER_M2:
        for way, name in enumerate(names):
            others = np.sort(np.concatenate([sort_out(field, way)[1] for field in chosen]))[::-1]
            threshold = float(others[min(round(wanted * fields * SIDE_M**2), len(others) - 1)])
            best = np.concatenate([sort_out(field, way)[0] for field in tested])
            depth = np.concatenate([field.mines[:, 2] for field in tested])
            false = sum(int((sort_out(field, way)[1] >= threshold).sum()) for field in tested)
            cells = []
            for each in DEPTHS:
                of = best[depth == each]
                hits = int((of >= threshold).sum())
                low, high = binomial_interval(hits, len(of))
                cells.append(f"{hits} of {len(of)} ({low:.2f} to {high:.2f})")
            lines.append([f"{wanted:g}", name, f"{threshold:.2f}", f"{false / fields / SIDE_M**2:.3f}", *cells])
    head = ["false per m², wanted", "temperatures of", "threshold", "false per m², found"]
    return table([*head, *(f"{100 * depth:g} cm" for depth in DEPTHS)], lines)


def _clock(hour: float) -> str:
    return f"{int(hour):02d}:{round(60 * (hour % 1)):02d}"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(prog="python -m tools.evaluate.two_visits", description=__doc__.split("\n")[0])
    parser.add_argument("--fields", type=int, default=40, help="to set thresholds on, and as many to count mines on")
    parser.add_argument("--seed", type=int, default=4100)
    parser.add_argument("--hours", type=float, nargs=2, default=(7.5, 15.5), metavar="H")
    options = parser.parse_args()
    print(report(options.fields, options.seed, (options.hours[0], options.hours[1]), Season()))


if __name__ == "__main__":
    main()
