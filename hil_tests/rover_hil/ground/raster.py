"""Where the cells of a ground raster lie in the map.

Row 0 is the southern (lowest y) row: `raster[row, column]` has its centre at
x = origin_x + (column + 0.5)·resolution, y = origin_y + (row + 0.5)·resolution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Window = tuple[slice, slice]


@dataclass(frozen=True)
class Grid:
    """A regular raster: outer corner of cell [0, 0] in metres, cell size in metres, size in cells."""

    origin_x: float
    origin_y: float
    resolution: float
    columns: int
    rows: int

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    def window(self, centre: tuple[float, float], reach: float) -> Window:
        """Slices of the square of half-width `reach` around `centre`, cut at the raster's edge."""
        column = (centre[0] - self.origin_x) / self.resolution
        row = (centre[1] - self.origin_y) / self.resolution
        cells = reach / self.resolution
        return (
            slice(max(0, int(row - cells)), max(0, min(self.rows, int(row + cells) + 2))),
            slice(max(0, int(column - cells)), max(0, min(self.columns, int(column + cells) + 2))),
        )

    def offsets(
        self, window: Window, centre: tuple[float, float]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """x and y of the window's cell centres minus `centre`: shapes (1, columns) and (rows, 1), metres."""
        columns, rows = (np.arange(part.start, part.stop, dtype=np.float64) for part in (window[1], window[0]))
        x = self.origin_x + (columns + 0.5) * self.resolution - centre[0]
        y = self.origin_y + (rows + 0.5) * self.resolution - centre[1]
        return x[None, :], y[:, None]
