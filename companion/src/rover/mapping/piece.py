"""One submap in the map of the area: its rasters while they are in use, and what is known of them packed tight.

A window of rasters holds several cells for each that is known, and a large field has a hundred submaps of which the
rover is near a few: the others sleep, packed as they lie in a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mapping.local_grid import LAYERS, LocalGrid
from rover.mapping.rectangle import Rectangle

AT_HOME = Pose2(0.0, 0.0, 0.0)
# The bits of a window's cells that are known, row by row; the layers are then their values alone.
KNOWN = "known"


class Piece:
    """What one submap has learned, and its frame's pose in map as it is shown."""

    def __init__(self, grid: LocalGrid | None = None, pose: Pose2 = AT_HOME) -> None:
        self.pose = pose
        self._grid: LocalGrid | None = grid or LocalGrid()
        self._window = self._grid.window
        self._packed: dict[str, NDArray[Any]] | None = None
        # Whether anybody has asked for the rasters since `rest`.
        self._used = True

    @property
    def window(self) -> Rectangle:
        """Of the submap's lattice: what the rasters cover."""
        return self._window if self._grid is None else self._grid.window

    @property
    def grid(self) -> LocalGrid:
        """The rasters, to be read."""
        self._used = True
        if self._grid is None:
            assert self._packed is not None
            self._grid = unpacked(self._window, self._packed)
        return self._grid

    @property
    def asleep(self) -> bool:
        """Whether only the packed form is there."""
        return self._grid is None

    def to_change(self) -> LocalGrid:
        """The rasters, to be written."""
        grid = self.grid
        self._packed = None
        return grid

    def packed(self) -> dict[str, NDArray[Any]]:
        """Window and what is known, by name; nobody changes these arrays any more."""
        if self._packed is None:
            assert self._grid is not None
            self._packed = packed(self._grid)
        return self._packed

    def sleep(self) -> None:
        """Keeps the packed form alone."""
        self.packed()
        if self._grid is not None:
            self._window, self._grid = self._grid.window, None

    def rest(self) -> None:
        """Sleeps where nobody has asked for the rasters since this was called last."""
        if not self._used:
            self.sleep()
        self._used = False


def packed(grid: LocalGrid) -> dict[str, NDArray[Any]]:
    """A grid's window and the values of its known cells, by name."""
    window = grid.window
    known = (grid.stamp > 0) | (grid.temperature_count > 0)
    found: dict[str, NDArray[Any]] = {
        "window": np.array([window.top, window.left, window.bottom, window.right], np.int64),
        KNOWN: np.packbits(known),
    }
    return found | {name: layer[known] for name, layer in grid.layers().items()}


def unpacked(window: Rectangle, layers: Mapping[str, NDArray[Any]]) -> LocalGrid:
    """The grid again; layers without KNOWN cover the whole window. Raises ValueError when they do not fit."""
    grid = LocalGrid(window)
    if KNOWN not in layers:
        grid.restore(layers)
        return grid
    count = window.shape[0] * window.shape[1]
    bits = layers[KNOWN]
    if bits.dtype != np.uint8 or bits.shape != ((count + 7) // 8,):
        raise ValueError("the known cells do not fit")
    known = np.unpackbits(bits, count=count).astype(bool).reshape(window.shape)
    whole: dict[str, NDArray[Any]] = {}
    for name, (kind, unknown) in LAYERS.items():
        values = layers.get(name)
        if values is None or values.dtype != kind or values.shape != (int(known.sum()),):
            raise ValueError(f"layer {name} does not fit")
        whole[name] = np.full(window.shape, unknown, kind)
        whole[name][known] = values
    grid.restore(whole)
    return grid
