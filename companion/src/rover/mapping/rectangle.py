"""A rectangle of cells on the lattice of a map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2


@dataclass(frozen=True)
class Rectangle:
    """Rows [top, bottom) and columns [left, right); cell (row, column) begins at (column, row) × resolution."""

    top: int
    left: int
    bottom: int
    right: int

    @classmethod
    def around(cls, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Rectangle:
        """The smallest one that holds these cells, at least one."""
        return cls(int(rows.min()), int(columns.min()), int(rows.max()) + 1, int(columns.max()) + 1)

    @property
    def empty(self) -> bool:
        """True when no cell lies in it."""
        return self.bottom <= self.top or self.right <= self.left

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return max(self.bottom - self.top, 0), max(self.right - self.left, 0)

    def grown(self, cells: int) -> Rectangle:
        """With so many cells more on every side."""
        return Rectangle(self.top - cells, self.left - cells, self.bottom + cells, self.right + cells)

    def within(self, other: Rectangle) -> Rectangle:
        """What both have in common; may be empty."""
        return Rectangle(
            max(self.top, other.top),
            max(self.left, other.left),
            min(self.bottom, other.bottom),
            min(self.right, other.right),
        )

    def joined(self, other: Rectangle) -> Rectangle:
        """The smallest one that holds both."""
        return Rectangle(
            min(self.top, other.top),
            min(self.left, other.left),
            max(self.bottom, other.bottom),
            max(self.right, other.right),
        )

    def slices(self, origin: Rectangle) -> tuple[slice, slice]:
        """Of an array whose first cell is the first of `origin`; must lie within that."""
        return (
            slice(self.top - origin.top, self.bottom - origin.top),
            slice(self.left - origin.left, self.right - origin.left),
        )

    def centres(self, resolution: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """x (1, columns) and y (rows, 1) of the middles of its cells, metres."""
        x = (np.arange(self.left, self.right, dtype=np.float64) + 0.5) * resolution
        y = (np.arange(self.top, self.bottom, dtype=np.float64) + 0.5) * resolution
        return x[None, :], y[:, None]

    def moved(self, pose: Pose2, resolution: float) -> Rectangle:
        """The smallest one that holds its cells after a move by `pose`, and those that share a corner with them."""
        if self.empty:
            return self
        corners = np.array([(x, y) for x in (self.left, self.right) for y in (self.top, self.bottom)], dtype=np.float64)
        low, high = (edge(pose.transform(corners * resolution) / resolution, axis=0) for edge in (np.min, np.max))
        left, top = np.floor(low).astype(int).tolist()
        right, bottom = np.ceil(high).astype(int).tolist()
        return Rectangle(top, left, bottom, right).grown(1)
