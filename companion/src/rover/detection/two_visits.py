"""Two surveys of one field at two hours: what both temperatures together say of a place.

Ground differs from place to place in albedo, conductivity and heat capacity, and does so at every hour; what it does at
two hours is correlated as its causes are. A mine in it follows the day in its own way: by day warmer, at night colder,
for the soil above it stores less heat. Fisher's linear discriminant of both contrasts, with the covariance that this
very ground shows, weighs the two visits and their difference so that what ground does by itself counts least; how the
contrasts of two hours compare depends on the depth, and of several depths the likeliest counts.

The apparent thermal inertia of a place beside that of its surroundings is the ratio of the surroundings' change between
the visits to its own: below one where less heat is stored.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.detection.hours import typical
from rover.detection.second_look import LEAST_SPREAD_K, contrast, peaks

Raster = NDArray[np.float32]

# Answers beyond so many robust deviations are things, and tell nothing of how plain ground varies.
PLAIN_SIGMAS = 3.0
# Share of the variance of a normal distribution that is left once it is cut off at PLAIN_SIGMAS.
LEFT_OF_VARIANCE = 0.973
# Likeness from which a place is reported by both visits together, and from which it is as likely a mine as not, and how
# steeply that rises (`python -m tools.evaluate.two_visits`).
REPORT = 3.6
EVEN, STEEPNESS = 3.4, 2.0
# Change of the surroundings between the visits below which their inertia can't be told, kelvin.
LEAST_CHANGE_K = 3.0


@dataclass(frozen=True, eq=False)
class TwoVisits:
    """Of one field, in the second visit's map. kelvin: mosaic of each visit, nan where it saw nothing.

    contrast: of each, kelvin, nan where too little is known. likeness: by both together, in standard deviations of this
    ground's answers; by one where only one knows. All (rows, columns). hours: of the day, 0 to 24.
    """

    hours: tuple[float, float]
    resolution: float
    kelvin: tuple[Raster, Raster]
    contrast: tuple[Raster, Raster]
    likeness: Raster

    @property
    def difference(self) -> Raster:
        """Second less first, each less the median of what both saw, kelvin; nan where one saw nothing."""
        first, second = self.kelvin
        change = second - first
        known = np.isfinite(change)
        return change - np.float32(np.median(change[known])) if known.any() else change

    def spots(self, least: float = REPORT) -> NDArray[np.float64]:
        """Places (N, 3) of at least that likeness: x, y in metres from the map's corner, and likeness."""
        return peaks(self.likeness, self.resolution, least)

    def at(self, x: float, y: float) -> PlaceOfTwo:
        """What both say of a place; x, y in metres from the map's corner."""
        rows, columns = self.likeness.shape
        row = min(max(int(y / self.resolution), 0), rows - 1)
        column = min(max(int(x / self.resolution), 0), columns - 1)
        near = np.s_[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        best = int(np.argmax(self.likeness[near]))
        first, second = (float(one[near].ravel()[best]) for one in self.contrast)
        return PlaceOfTwo(float(self.likeness[near].ravel()[best]), first, second, self._inertia(row, column))

    def _inertia(self, row: int, column: int) -> float | None:
        reach = max(1, round(0.15 / self.resolution))
        window = np.s_[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1]
        change = (self.kelvin[1] - self.kelvin[0])[window]
        own = (self.kelvin[1] - self.kelvin[0])[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        if not np.isfinite(own).any():
            return None
        around = float(np.nanmedian(change))
        here = float(np.nanmean(own))
        return around / here if abs(around) >= LEAST_CHANGE_K and abs(here) >= LEAST_CHANGE_K else None


@dataclass(frozen=True)
class PlaceOfTwo:
    """likeness: by both visits. first, second: contrast, kelvin, nan where not known.

    inertia: apparent thermal inertia as a share of that of the ground around, None where it can't be told.
    """

    likeness: float
    first: float
    second: float
    inertia: float | None

    @property
    def p(self) -> float:
        """Probability that a peak of this likeness is a mine, as on the simulated fields it was measured on."""
        return float(1.0 / (1.0 + np.exp(np.clip(-STEEPNESS * (self.likeness - EVEN), -30.0, 30.0))))


def compare(first: Raster, second: Raster, hours: tuple[float, float], resolution: float) -> TwoVisits:
    """Two mosaics (rows, columns) of one map, kelvin, nan where nothing is known, taken at these hours."""
    answers = contrast(first, resolution), contrast(second, resolution)
    covariance = _plain_covariance(answers)
    spread = np.sqrt(np.diag(covariance))
    like = np.full(first.shape, -np.inf, np.float32)
    for wanted in np.array([typical(hour) for hour in hours]).T:
        # As deep as this one: the discriminant of both, or what the one visit says that knows the place.
        weights = np.linalg.solve(covariance, wanted)
        both = (weights[0] * answers[0] + weights[1] * answers[1]) / float(np.sqrt(wanted @ weights))
        alone = [np.sign(wanted[k]) * answers[k] / spread[k] for k in (0, 1)]
        said = np.where(np.isfinite(both), both, np.where(np.isfinite(alone[0]), alone[0], alone[1]))
        like = np.maximum(like, np.nan_to_num(said).astype(np.float32))
    return TwoVisits(hours, resolution, (first, second), answers, like)


def _plain_covariance(answers: tuple[Raster, Raster]) -> NDArray[np.float64]:
    """Covariance (2, 2) of both contrasts on plain ground, kelvin²: things that stand out are left out."""
    spread = np.array([_spread(answer) for answer in answers])
    pairs = np.column_stack([answer.ravel() for answer in answers]).astype(np.float64)
    pairs = pairs[np.isfinite(pairs).all(axis=1)]
    plain = pairs[(np.abs(pairs) <= PLAIN_SIGMAS * spread).all(axis=1)]
    if len(plain) < 100:
        return np.diag(spread**2)
    return np.asarray(plain.T @ plain / len(plain) / LEFT_OF_VARIANCE + LEAST_SPREAD_K**2 * np.eye(2))


def _spread(answer: Raster) -> float:
    known = answer[np.isfinite(answer)]
    return max(1.4826 * float(np.median(np.abs(known))), LEAST_SPREAD_K) if known.size else 1.0
