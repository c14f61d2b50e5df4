"""What one submap has learned of the ground, in its own frame: a window of rasters that grows with what is seen.

Occupancy is kept as log-odds, one layer per sensor, because the two err in different ways: the camera knows well
where a thing begins and takes a warm mine for no obstacle; the sonar knows that something stands there, but not where
in its cone. The parallax (`rover.mapping.parallax`) says plainly what stands. A cell is occupied when any of them says
so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.mapping.look import Look
from rover.mapping.rectangle import Rectangle
from rover.mapping.sonar_cone import ConeUpdate

# Log-odds of one frame, their limits, and from where on a cell counts as occupied.
THERMAL_HIT = 0.7
THERMAL_FREE = -0.6
LIMITS = (-2.0, 2.4)
OCCUPIED = 1.2
# What is narrower than three cells is a pebble or an edge, not an obstacle.
SMALLEST = np.ones((3, 3), np.uint8)
# An echo within three cells of an obstacle that the camera shows is the echo of that obstacle.
ECHO_SLACK = np.ones((7, 7), np.uint8)
# A frame that shows plain ground takes this from the sonar layer, where no close echo speaks against it.
SONAR_FREED = -0.35
# Echoes outweigh the camera once so many close ones have come.
PERSISTENT = 3
# Frames after which the mosaic forgets the first ones.
MOSAIC_MEMORY = 50
# Cells around a change within which what counts as an obstacle may change with it, and an echo's weight.
REACH = 6
# The window grows in steps of so many cells.
BLOCK = 64

# What is learned, by its name in files, with the value of ground of which nothing is known.
LAYERS: dict[str, tuple[type[np.generic], float]] = {
    "seen": (np.bool_, 0),
    "thermal": (np.float32, 0),
    "sonar": (np.float32, 0),
    "standing": (np.bool_, 0),
    "temperature": (np.float32, np.nan),
    "temperature_count": (np.uint8, 0),
    "close_echoes": (np.uint8, 0),
    # When the cell was learned of last; of a cell taken over from another submap, when that had learned of it.
    "stamp": (np.uint32, 0),
}


class LocalGrid:
    """Rasters over `window`, a rectangle of the submap's lattice. Each layer in LAYERS is an attribute of that name."""

    seen: NDArray[np.bool_]
    thermal: NDArray[np.float32]
    sonar: NDArray[np.float32]
    standing: NDArray[np.bool_]
    temperature: NDArray[np.float32]
    temperature_count: NDArray[np.uint8]
    close_echoes: NDArray[np.uint8]
    stamp: NDArray[np.uint32]

    def __init__(self, window: Rectangle | None = None) -> None:
        self.window = window or Rectangle(0, 0, 0, 0)
        for name, (kind, unknown) in LAYERS.items():
            setattr(self, name, np.full(self.window.shape, unknown, kind))
        self.occupied: NDArray[np.bool_] = np.zeros(self.window.shape, bool)
        # What stands by the camera, without what is too small; and what an echo may come from because of it.
        self._solid: NDArray[np.bool_] = np.zeros(self.window.shape, bool)
        self._near_obstacle: NDArray[np.bool_] = np.zeros(self.window.shape, bool)

    def layers(self) -> dict[str, NDArray[Any]]:
        """All that has been learned, by name; rasters of the window."""
        return {name: getattr(self, name) for name in LAYERS}

    def restore(self, layers: Mapping[str, NDArray[Any]]) -> None:
        """Takes over what a grid with the same window had learned. Raises ValueError when it does not fit."""
        for name, (kind, _) in LAYERS.items():
            given = layers.get(name)
            if given is None or given.shape != self.window.shape or given.dtype != kind:
                raise ValueError(f"layer {name} does not fit")
            getattr(self, name)[:] = given
        self._find_obstacles(self.window)

    def cover(self, wanted: Rectangle) -> None:
        """Grows the window so that it holds `wanted`, and room for what a change there reaches."""
        wanted = wanted.grown(2 * REACH)
        if wanted.within(self.window) == wanted:
            return
        both = wanted if self.window.empty else wanted.joined(self.window)
        grown = Rectangle(
            both.top // BLOCK * BLOCK,
            both.left // BLOCK * BLOCK,
            -(-both.bottom // BLOCK) * BLOCK,
            -(-both.right // BLOCK) * BLOCK,
        )
        other = LocalGrid(grown)
        if not self.window.empty:
            at = self.window.slices(grown)
            for name in (*LAYERS, "occupied", "_solid", "_near_obstacle"):
                getattr(other, name)[at] = getattr(self, name)
        self.__dict__.update(other.__dict__)

    def look(self, look: Look, weight: float, stamp: int) -> None:
        """Takes in one frame, which the window must cover; weight: of its obstacles, 1 for a certain pose."""
        where = Rectangle.around(look.rows, look.columns)
        at = where.slices(self.window)
        rows, columns = look.rows - where.top, look.columns - where.left
        # Several points fall into a cell: the cell is what any of its points is.
        hit, free = np.zeros(where.shape, bool), np.zeros(where.shape, bool)
        hit[rows[look.solid], columns[look.solid]] = True
        free[rows[look.shown], columns[look.shown]] = True
        free &= ~hit
        self.seen[at] |= free
        thermal, sonar = self.thermal[at], self.sonar[at]
        change = np.float32(THERMAL_HIT * weight) * hit + np.float32(THERMAL_FREE * weight) * free
        np.clip(thermal + change, *LIMITS, out=thermal)
        freed = free & (self.close_echoes[at] < PERSISTENT) & (sonar > 0.0)
        sonar[freed] += np.float32(SONAR_FREED * weight)
        self._add_temperature(at, where.shape, rows[look.shown], columns[look.shown], look.kelvin[look.shown])
        self.stamp[at][hit | free] = stamp
        self._find_obstacles(where.grown(REACH))

    def ping(self, update: ConeUpdate, stamp: int) -> None:
        """Takes in one ping, which the window must cover."""
        at = update.rows - self.window.top, update.columns - self.window.left
        # Where the camera shows an obstacle in the arc, the echo came from there and says nothing of the rest.
        near, hit = self._near_obstacle[at], update.change > 0.0
        change = np.where(hit & ~near, 0.0, update.change) if (near & hit).any() else update.change
        self.sonar[at] = np.clip(self.sonar[at] + change, *LIMITS)
        close = self.close_echoes[at]
        self.close_echoes[at] = np.where(
            update.near & (change > 0.4),
            np.minimum(close + 1, 2 * PERSISTENT),
            np.where(change < 0.0, np.maximum(close, 1) - 1, close),
        )
        self.stamp[at] = stamp
        self.occupied[at] = self._solid[at] | (self.sonar[at] > OCCUPIED) | self.standing[at]

    def stand(self, where: Rectangle, judged: NDArray[np.bool_], standing: NDArray[np.bool_], stamp: int) -> None:
        """What the parallax says of the judged cells, masks over `where`, which the window must cover."""
        at = where.slices(self.window)
        self.standing[at][judged] = standing[judged]
        self.stamp[at][judged] = stamp
        self.occupied[at] = self._solid[at] | (self.sonar[at] > OCCUPIED) | self.standing[at]

    def take_over(self, where: Rectangle, cells: NDArray[np.bool_], layers: Mapping[str, NDArray[Any]]) -> None:
        """What another submap has learned of `cells`, a mask over `where`; layers: rasters over `where`, by name."""
        at = where.slices(self.window)
        for name in LAYERS:
            getattr(self, name)[at][cells] = layers[name][cells]
        self._find_obstacles(where.grown(REACH).within(self.window))

    def _find_obstacles(self, where: Rectangle) -> None:
        """Anew what counts as occupied, in and around `where`; beyond the window nothing is."""
        look = where.grown(REACH).within(self.window)
        strong = (self.thermal[look.slices(self.window)] > OCCUPIED).astype(np.uint8)
        inside = where.within(self.window)
        at, cut = inside.slices(self.window), inside.slices(look)
        if strong.any():
            solid = np.asarray(cv2.morphologyEx(strong, cv2.MORPH_OPEN, SMALLEST), np.uint8)
            self._solid[at] = solid[cut] > 0
            self._near_obstacle[at] = cv2.dilate(solid, ECHO_SLACK)[cut] > 0
        else:
            self._solid[at] = self._near_obstacle[at] = False
        self.occupied[at] = self._solid[at] | (self.sonar[at] > OCCUPIED) | self.standing[at]

    def _add_temperature(
        self,
        at: tuple[slice, slice],
        shape: tuple[int, int],
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        kelvin: NDArray[np.float32],
    ) -> None:
        flat, size = rows * shape[1] + columns, shape[0] * shape[1]
        number = np.bincount(flat, minlength=size).reshape(shape)
        total = np.bincount(flat, kelvin, minlength=size).reshape(shape)
        touched = number > 0
        counts, temperature = self.temperature_count[at], self.temperature[at]
        count = np.minimum(counts[touched] + 1, MOSAIC_MEMORY).astype(np.uint8)
        before = np.nan_to_num(temperature[touched])
        temperature[touched] = before + (total[touched] / number[touched] - before) / count
        counts[touched] = count
