"""The map of the area, put together from what each submap has learned: seen ground, occupied ground, temperatures.

Every submap keeps rasters of its own, in its own frame (`local_grid`). A cell of the map shows the submap that has
learned of that ground last; a submap that comes to ground which another one knows better takes that over first. So
nothing is averaged over submaps that do not lie exactly as they are believed to, and when they move against each other
the map is only put together anew, where they moved by more than a part of a cell: around the rover at once, elsewhere
in a large field some tiles with each frame. Wherever a frame changes something, only the cells around are looked at.

Row 0 lies at y = 0, column 0 at x = 0 of map.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.camera_view import CameraView, view_polygon
from rover.mapping.local_grid import REACH, LocalGrid
from rover.mapping.look import look_at
from rover.mapping.parallax import Judged
from rover.mapping.piece import AT_HOME, Piece, unpacked
from rover.mapping.rectangle import Rectangle
from rover.mapping.sonar_cone import cone_update
from rover.mapping.spot import ClassifiedSpot
from rover.vehicle import SonarMount
from rover.vision.camera.model import CameraModel

# Echoes nearer than this, metres, count as close.
CLOSE_ECHO = 0.40
# A pose less certain than this, metres, still shows the ground but maps obstacles with less weight.
SURE_POSE = 0.03
# Ground so far beyond the area is learned, too: a submap may be moved by as much. Metres.
BEYOND_M = 0.6
# A submap is put into the map anew when a corner of what it has learned has moved by this share of a cell.
MOVED_CELLS = 0.25

# Cells that are put together anew at once, wherever they lie; beyond that so many tiles with each frame, 10 ms each.
AT_ONCE = 100_000
TILES_A_FRAME = 3
TILE = (64, 256)
NOBODY = np.iinfo(np.uint16).max


class SurveyGrid:
    """Rasters (rows, columns) over an area of width x height metres from map's origin.

    seen, occupied: bool. thermal: log-odds of an obstacle by the camera. temperature: kelvin, nan where nothing is
    known. owner: the submap that a cell is shown from.
    """

    def __init__(self, width: float, height: float, resolution: float = 0.02) -> None:
        self.resolution = resolution
        self.shape = (int(np.ceil(height / resolution - 1e-9)), int(np.ceil(width / resolution - 1e-9)))
        self.area = Rectangle(0, 0, *self.shape)
        self.seen: NDArray[np.bool_] = np.zeros(self.shape, bool)
        self.occupied: NDArray[np.bool_] = np.zeros(self.shape, bool)
        self.thermal: NDArray[np.float32] = np.zeros(self.shape, np.float32)
        self.temperature: NDArray[np.float32] = np.full(self.shape, np.nan, np.float32)
        self.owner: NDArray[np.uint16] = np.full(self.shape, NOBODY, np.uint16)
        self._stamp: NDArray[np.uint32] = np.zeros(self.shape, np.uint32)
        self._limits = self.area.grown(math.ceil(BEYOND_M / resolution))
        self._pieces = [Piece()]
        self._active = 0
        self._now = 0
        # Grows whenever ground that is shown has moved.
        self.moves = 0
        self._view: CameraView | None = None
        # Of the map, still to be put together anew.
        self._waiting: list[Rectangle] = []
        # What has changed since somebody asked, by `changes`.
        self._changed: list[Rectangle] = []

    @property
    def active(self) -> int:
        """Number of the submap that the rover is in."""
        return self._active

    @property
    def pieces(self) -> list[Piece]:
        """Of every submap, by number."""
        return self._pieces

    def changed(self, where: Rectangle) -> None:
        """Cells within `where` are about to be told as changed."""
        self._changed.append(where)

    def changes(self) -> list[Rectangle]:
        """Where cells may have changed since this was asked last."""
        changed, self._changed = self._changed, []
        return changed

    def view_polygon(self, camera: CameraModel) -> NDArray[np.float64]:
        """Convex outline (N, 2) in base_link of what `integrate_frame` marks as seen on open ground."""
        return view_polygon(camera)

    def place(self, poses: Sequence[Pose2], active: int) -> None:
        """Where the submaps lie in map now, and the one that the rover is in; new ones follow those that are known."""
        while len(self._pieces) < len(poses):
            self._pieces.append(Piece(pose=poses[len(self._pieces)]))
        if active != self._active:
            for number, piece in enumerate(self._pieces):
                if number != active:
                    piece.rest()
        self._active = active
        moved = [
            piece for piece, pose in zip(self._pieces, poses, strict=True) if self._shift(piece, pose) > MOVED_CELLS
        ]
        if not moved:
            return
        self.moves += 1
        anew = np.zeros(self.shape, bool)
        for piece, pose in zip(self._pieces, poses, strict=True):
            if piece not in moved:
                continue
            for at in (piece.pose, pose):
                where = piece.window.moved(at, self.resolution).within(self.area)
                if not where.empty:
                    anew[where.slices(self.area)] = True
            piece.pose = pose
        for where in self._waiting:
            anew[where.slices(self.area)] = True
        tiles = _tiles(anew)
        if sum(tile.shape[0] * tile.shape[1] for tile in tiles) > AT_ONCE:
            own = self._pieces[active]
            near = own.window.moved(own.pose, self.resolution)
            self._waiting = [tile for tile in tiles if tile.within(near).empty]
            tiles = [tile for tile in tiles if not tile.within(near).empty]
        else:
            self._waiting = []
        self._compose(tiles)

    def settle(self, most: int | None = None) -> None:
        """Puts together what still waits for it; `most`: so many tiles, all when left out."""
        count = len(self._waiting) if most is None else most
        tiles, self._waiting = self._waiting[:count], self._waiting[count:]
        if tiles:
            self._compose(tiles)

    def integrate_frame(
        self, frame: Frame, camera: CameraModel, pose: Pose2, sigma: float, detections: Sequence[ClassifiedSpot]
    ) -> None:
        """One frame from `pose` in the frame of the submap that the rover is in; detections of this frame.

        sigma: 1σ of the position among the ground around, metres.
        """
        self.settle(TILES_A_FRAME)
        if self._view is None or self._view.camera is not camera:
            self._view = CameraView(camera, 0.75 * self.resolution)
        look = look_at(frame, self._view, pose, self.resolution, self._limits, detections)
        if look is None:
            return
        where = Rectangle.around(look.rows, look.columns)
        grid = self._begin(where)
        grid.look(look, 1.0 if sigma <= SURE_POSE else SURE_POSE / sigma, 2 * self._now)
        self._show(self._active, where.grown(REACH))

    def integrate_sonar(self, pose: Pose2, mount: SonarMount, range_m: float | None) -> None:
        """One ping from `pose`, as above; range_m in metres, None when no echo came back."""
        update = cone_update(self._limits, self.resolution, pose, mount, range_m, CLOSE_ECHO)
        if update is None:
            return
        where = Rectangle.around(update.rows, update.columns)
        grid = self._begin(where)
        grid.ping(update, 2 * self._now)
        self._show(self._active, where)

    def stand(self, found: Judged) -> None:
        """What the parallax says of ground in the rover's submap."""
        grid = self._begin(found.where)
        grid.stand(found.where, found.judged, found.standing, 2 * self._now)
        self._show(self._active, found.where)

    def layers(self) -> dict[str, NDArray[Any]]:
        """All that has been learned, by name, for every submap: arrays that are not changed any more."""
        return {
            f"{number}_{name}": layer
            for number, piece in enumerate(self._pieces)
            for name, layer in piece.packed().items()
        }

    def restore(self, layers: Mapping[str, NDArray[Any]], poses: Sequence[Pose2]) -> None:
        """Takes over what a map of the same area had learned in submaps that lie at `poses`.

        Raises ValueError when it does not fit.
        """
        pieces = []
        for number, pose in enumerate(poses):
            corners = layers.get(f"{number}_window")
            if corners is None or corners.shape != (4,) or corners.dtype != np.int64:
                raise ValueError(f"submap {number} is missing")
            window = Rectangle(*corners.tolist())
            if not window.empty and window.within(self._limits.grown(4 * REACH + 128)) != window:
                raise ValueError(f"submap {number} does not fit")
            own = {name.removeprefix(f"{number}_"): layer for name, layer in layers.items()
                   if name.startswith(f"{number}_")}  # fmt: skip
            grid = unpacked(window, own)
            self._now = max(self._now, (int(grid.stamp.max(initial=0)) + 1) // 2)
            pieces.append(Piece(grid, pose))
            pieces[-1].sleep()
        self._pieces, self._active = pieces, 0
        self._compose([self.area])

    def _begin(self, where: Rectangle) -> LocalGrid:
        """The grid of the rover's submap, ready for a change of `where`, with what others have learned there since."""
        self._now += 1
        piece = self._pieces[self._active]
        grid = piece.to_change()
        grid.cover(where)
        if len(self._pieces) > 1:
            self._take_over(piece, where.grown(REACH))
        return grid

    def _take_over(self, piece: Piece, around: Rectangle) -> None:
        """Into the rover's submap, within a rectangle of its lattice, what others have learned there since."""
        grid, resolution = piece.grid, self.resolution
        own = _age(grid.stamp[around.slices(grid.window)])
        (rows, columns), inside = _cells_seen_from(around, piece.pose, AT_HOME, self.area, resolution)
        owners = self.owner[rows, columns]
        newer = inside & (owners != self._active) & (_age(self._stamp[rows, columns]) > own)
        for owner in np.unique(owners[newer]).tolist():
            other = self._pieces[owner]
            there, known = _cells_seen_from(around, piece.pose, other.pose, other.window, resolution)
            stamp = other.grid.stamp[there]
            cells = newer & (owners == owner) & known & (_age(stamp) > own)
            layers = {name: layer[there] for name, layer in other.grid.layers().items()}
            # Of what was taken over and what it was taken from, the map shows the latter.
            layers["stamp"] = 2 * _age(stamp) - np.uint32(1)
            grid.take_over(around, cells, layers)
            self._show(self._active, around.grown(REACH))

    def _show(self, number: int, changed: Rectangle) -> None:
        """Brings the map up to date where one submap has changed within a rectangle of its own lattice."""
        piece = self._pieces[number]
        where = changed.moved(piece.pose, self.resolution).within(self.area)
        if where.empty:
            return
        self._merge(number, where)
        self._changed.append(where)

    def _compose(self, parts: Sequence[Rectangle]) -> None:
        """Puts the map together anew within rectangles of it."""
        for where in parts:
            at = where.slices(self.area)
            self.owner[at], self._stamp[at] = NOBODY, 0
            self.seen[at], self.occupied[at], self.thermal[at], self.temperature[at] = False, False, 0.0, np.nan
        for number, piece in enumerate(self._pieces):
            asleep = piece.asleep
            for where in parts:
                common = piece.window.moved(piece.pose, self.resolution).within(where)
                if not common.empty:
                    self._merge(number, common)
            if asleep:
                piece.sleep()
        self._changed += parts

    def _merge(self, number: int, where: Rectangle) -> None:
        """Shows a submap wherever, within `where`, it has learned last; of two equal ones the elder is shown."""
        piece = self._pieces[number]
        grid, at = piece.grid, where.slices(self.area)
        inside: NDArray[np.bool_] | bool = True
        cells: tuple[Any, Any]
        if piece.pose == AT_HOME:  # cell by cell the same lattice
            where = where.within(grid.window)
            if where.empty:
                return
            at, cells = where.slices(self.area), where.slices(grid.window)
        else:
            cells, inside = _cells_seen_from(where, AT_HOME, piece.pose, grid.window, self.resolution)
        stamp, known, owner = grid.stamp[cells], self._stamp[at], self.owner[at]
        shown = inside & (stamp > 0) & ((stamp > known) | (owner == number) | ((stamp == known) & (owner > number)))
        np.copyto(known, stamp, where=shown)
        owner[shown] = number
        np.copyto(self.seen[at], grid.seen[cells], where=shown)
        np.copyto(self.occupied[at], grid.occupied[cells], where=shown)
        np.copyto(self.thermal[at], grid.thermal[cells], where=shown)
        np.copyto(self.temperature[at], grid.temperature[cells], where=shown)

    def _shift(self, piece: Piece, pose: Pose2) -> float:
        """By how many cells a corner of what it has learned moves at most when it goes to `pose`."""
        if pose == piece.pose or piece.window.empty:
            piece.pose = pose
            return 0.0
        window = piece.window
        corners = np.array([(x, y) for x in (window.left, window.right) for y in (window.top, window.bottom)], float)
        corners *= self.resolution
        apart = pose.transform(corners) - piece.pose.transform(corners)
        return float(np.hypot(*apart.T).max()) / self.resolution


def _age(stamp: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """The same of what was learned and of a copy of it."""
    age: NDArray[np.uint32] = (stamp + np.uint32(1)) // np.uint32(2)
    return age


def _cells_seen_from(
    where: Rectangle, own: Pose2, other: Pose2, window: Rectangle, resolution: float
) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], NDArray[np.bool_]]:
    """For each cell of `where`, a rectangle of the lattice at `own`, the cell that its middle has in that at `other`.

    Returns row and column within `window` of that one, clipped to it, and whether it lies in it; all (rows, columns).
    """
    if own == other:
        rows, columns = np.meshgrid(
            np.arange(where.top, where.bottom), np.arange(where.left, where.right), indexing="ij"
        )
    else:
        between = own.relative_to(other)
        x, y = where.centres(resolution)
        c, s = math.cos(between.heading), math.sin(between.heading)
        columns = np.floor((between.x + c * x - s * y) / resolution).astype(np.intp)
        rows = np.floor((between.y + s * x + c * y) / resolution).astype(np.intp)
    rows, columns = rows - window.top, columns - window.left
    height, width = window.shape
    inside = (rows >= 0) & (columns >= 0) & (rows < height) & (columns < width)
    return (np.clip(rows, 0, max(height - 1, 0)), np.clip(columns, 0, max(width - 1, 0))), inside


def _tiles(mask: NDArray[np.bool_]) -> list[Rectangle]:
    """Rectangles that together hold all cells of a mask, none of them larger than TILE."""
    found = []
    height, width = TILE
    for top in range(0, mask.shape[0], height):
        for left in range(0, mask.shape[1], width):
            part = mask[top : top + height, left : left + width]
            rows, columns = np.flatnonzero(part.any(axis=1)), np.flatnonzero(part.any(axis=0))
            if len(rows):
                found.append(
                    Rectangle(
                        top + int(rows[0]), left + int(columns[0]), top + int(rows[-1]) + 1, left + int(columns[-1]) + 1
                    )
                )
    return found
