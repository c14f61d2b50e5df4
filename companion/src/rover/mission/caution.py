"""Where no wheel goes while there is another way: weak spots of the mosaic, neither suspected nor reported.

A spot is one that the second look finds (`rover.detection.second_look`). At first all of CAUTIOUS are kept free; where
that leaves no way to anything, only those of BOLD are. A spot that a wheel has already gone over is none any more.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.second_look import likeness, peaks
from rover.geometry import Pose2
from rover.mapping.local_grid import OCCUPIED
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.freespace import FreeSpace, keep_off
from rover.vehicle import Vehicle

# Likeness from which a spot is kept free, in standard deviations of the ground's answers: while there is another way,
# and in any case. A mine 5 cm deep at one in the afternoon answers with about 4; bare loam has one or two spots of 2.5
# a square metre and one of 3.2 in four.
CAUTIOUS, BOLD = 2.5, 3.2
# A spot that comes up while a stretch is driven must be so much likelier: the ground's spread is estimated anew with
# every frame, and what lies near the threshold comes and goes.
SURER = 0.5
# Half the side of a spot that nothing of the rover may touch, metres: its wheels, which stand 3 cm within the hull and
# its margin, then stay 3 cm off a mine of 11 cm that lies up to 4 cm from where the spot peaks.
SPOT_RADIUS = 0.045
# A spot nearer than this to the rover's centre lies under it, metres: no way out of it would be found.
UNDER = 0.08
# Half the side of the window that is looked at anew with every frame, metres: what a frame shows, and the ring around.
WINDOW = 1.7
# Cells that are looked at with one frame where all of the map is to be: 10 ms.
STRIP_CELLS = 60_000

# What is left out around an obstacle, and counts as driven around a wheel: a cell.
EDGE = np.ones((3, 3), np.uint8)


class Caution:
    """Weak spots of one survey. `likeness` has the grid's cells, in standard deviations of the ground's answers."""

    def __init__(self, grid: SurveyGrid, sign: int) -> None:
        """`sign`: of a buried mine's contrast at the mission's hour, 0 where it may be either."""
        self._grid = grid
        self._sign = sign
        self._driven = np.zeros(grid.shape, np.uint8)
        # Where wheels have stood, cells of every submap's lattice: what they went over moves with it.
        self._tracks: dict[int, set[tuple[int, int]]] = {}
        self._moves = grid.moves
        # Rows of the map that are still to be looked at.
        self._waiting: list[slice] = []
        self._spots = np.zeros(grid.shape, np.float32)  # likeness where it peaks, else 0
        self.likeness: NDArray[np.float32] | None = None

    def look(self, pose: Pose2) -> None:
        """Looks anew at the mosaic around the rover.

        At first, for an earlier run may have made it, and whenever ground has moved in map all of it is looked at, some
        rows with each frame.
        """
        size, (rows, columns) = self._grid.resolution, self._grid.shape
        if self.likeness is None or self._grid.moves != self._moves:
            self._begin_anew()
        reach, row, column = math.ceil(WINDOW / size), int(pose.y / size), int(pose.x / size)
        window = (
            slice(max(row - reach, 0), min(row + reach, rows)),
            slice(max(column - reach, 0), min(column + reach, columns)),
        )
        self._look_at(window)
        if self._waiting:
            self._look_at((self._waiting.pop(), slice(0, columns)))

    def _begin_anew(self) -> None:
        self._moves = self._grid.moves
        if self.likeness is None:
            self.likeness = np.zeros(self._grid.shape, np.float32)
        rows, columns = self._grid.shape
        step = max(STRIP_CELLS // columns, 2 * math.ceil(WINDOW / self._grid.resolution))
        self._waiting = [slice(top, min(top + step, rows)) for top in range(0, rows, step)]
        self._driven[:] = 0
        for number, cells in self._tracks.items():
            centres = (np.array(list(cells)) + 0.5) * self._grid.resolution
            places = self._grid.pieces[number].pose.transform(centres) / self._grid.resolution
            across, up = np.floor(places).astype(np.intp).T
            inside = (up >= 0) & (up < rows) & (across >= 0) & (across < columns)
            self._driven[up[inside], across[inside]] = 1
        self._driven = np.asarray(cv2.dilate(self._driven, EDGE), np.uint8)

    def _look_at(self, window: tuple[slice, slice]) -> None:
        assert self.likeness is not None
        self.likeness[window] = likeness(self._plain(window), self._grid.resolution, self._sign)
        self._find(*window)

    def _find(self, rows: slice, columns: slice) -> None:
        """The spots of a window; those outside are what they were."""
        assert self.likeness is not None
        size = self._grid.resolution
        found = peaks(self.likeness[rows, columns], size, CAUTIOUS)
        self._spots[rows, columns] = 0.0
        at = (found[:, [1, 0]] / size).astype(int) + np.array([rows.start, columns.start])
        self._spots[at[:, 0], at[:, 1]] = found[:, 2]

    def _plain(self, window: tuple[slice, slice]) -> NDArray[np.float32]:
        """The mosaic without obstacles and their edges, whose warmth is none of the ground's."""
        solid = cv2.dilate((self._grid.thermal[window] > OCCUPIED).astype(np.uint8), EDGE)
        return np.where(solid > 0, np.float32(np.nan), self._grid.temperature[window])

    def drive(self, pose: Pose2, vehicle: Vehicle) -> None:
        """Notes where the wheels stand: that ground bears."""
        size, half = self._grid.resolution, 0.5 * vehicle.track_width
        number = self._grid.active
        own, wheels = self._grid.pieces[number].pose, np.array([[0.0, half], [0.0, -half]])
        track = self._tracks.setdefault(number, set())
        for inside in np.floor(pose.relative_to(own).transform(wheels) / size).astype(int).tolist():
            cell = (inside[0], inside[1])
            if cell not in track:
                track.add(cell)
                x, y = own.transform((np.array([cell]) + 0.5) * size)[0].tolist()
                self._mark(x, y)

    def _mark(self, x: float, y: float) -> None:
        row, column = math.floor(y / self._grid.resolution), math.floor(x / self._grid.resolution)
        if 0 <= row < self._grid.shape[0] and 0 <= column < self._grid.shape[1]:
            self._driven[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2] = 1

    def keep_off(self, space: FreeSpace, least: float, pose: Pose2) -> FreeSpace:
        """The map with every spot of at least this likeness forbidden, but for those that a wheel has gone over."""
        if self.likeness is None:
            return space
        size = self._grid.resolution
        where = space.where
        near = where.slices(self._grid.area)
        rows, columns = np.nonzero((self._spots[near] >= least) & (self._driven[near] == 0))
        x, y = (columns + where.left + 0.5) * size, (rows + where.top + 0.5) * size
        away = np.hypot(x - pose.x, y - pose.y) >= UNDER
        return keep_off(space, np.column_stack((x, y, np.full(len(x), SPOT_RADIUS)))[away])
