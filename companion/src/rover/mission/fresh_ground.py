"""How much ground the wheels have touched: what counts where no detector sees every mine."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rover.vehicle import Vehicle

# Width of a tyre's contact, and the cells that it is counted in, metres.
TYRE_M = 0.025
CELL_M = 0.0125
# Along a tile's side, in cells: a track of any length is counted in as many tiles as it comes through.
TILE = 512


def fresh_wheel_area(track: NDArray[np.float64], vehicle: Vehicle) -> float:
    """Ground in m² that the wheels of a track (N, 3) of x, y, heading (metres, radians) pressed; each piece once."""
    tiles: dict[tuple[int, int], NDArray[np.uint8]] = {}
    half = 0.5 * vehicle.track_width
    for side in (half, -half):
        x = track[:, 0] - side * np.sin(track[:, 2])
        y = track[:, 1] + side * np.cos(track[:, 2])
        _press(tiles, x, y)
    return float(sum(int(tile.sum()) for tile in tiles.values())) * CELL_M**2


def _press(tiles: dict[tuple[int, int], NDArray[np.uint8]], x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
    """Draws a wheel's line, a tyre wide, into the tiles that it comes through."""
    columns, rows = np.round(x / CELL_M).astype(int), np.round(y / CELL_M).astype(int)
    # The first counts as moved to; of a rover that never knew where it was there is none.
    first = np.arange(min(1, len(columns)))
    moved = np.r_[first, np.flatnonzero((np.diff(columns) != 0) | (np.diff(rows) != 0)) + 1]
    width = max(1, round(TYRE_M / CELL_M))
    for column, row in zip(columns[moved].tolist(), rows[moved].tolist(), strict=True):
        for r in range(row - (width - 1) // 2, row + width // 2 + 1):
            for c in range(column - (width - 1) // 2, column + width // 2 + 1):
                key = (math.floor(r / TILE), math.floor(c / TILE))
                tile = tiles.setdefault(key, np.zeros((TILE, TILE), np.uint8))
                tile[r - key[0] * TILE, c - key[1] * TILE] = 1
