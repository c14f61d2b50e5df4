"""Lays the ground's texture from real pictures: a feathered mosaic of mine-free soil, and one cutting per mine.

Where two pictures meet they are blended with weights whose squares sum to one, so that a seam is neither
sharper nor duller than the texture beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

from rover_hil.ground.pictures import Entry, deviations, distinct, outside_boxes
from rover_hil.ground.placement import Point
from rover_hil.ground.raster import Grid
from rover_hil.ground.texture import correlated_noise

# Pitch of the soil tiles.
TILE_M = 0.75
FEATHER_M = 0.12
# How far a mine's own picture reaches around it, at most.
MAX_MINE_REACH_M = 0.80
# At least; as wide as 0.25 m where there is room.
MINE_FEATHER_M = 0.06
MAX_BOX_M = 0.45
# Pictures from higher up are coarser than the rover's own camera sees.
MAX_HEIGHT_M = 6.5
# Soil tiles keep this far off every labelled box.
BOX_MARGIN_M = 0.12


@dataclass(frozen=True)
class Cutting:
    """A labelled box to lay as a mine, how far its picture is usable around it (m) and its box (w, h)."""

    entry: Entry
    box: tuple[float, float, float, float]
    reach: float

    @property
    def half(self) -> float:
        """Half of the larger side of the box, m."""
        return 0.5 * max(self.box[2], self.box[3])


def cuttings(entries: Sequence[Entry], surface: bool) -> list[Cutting]:
    """Every box of known depth with enough soil of its own around it and no other box in there."""
    found = []
    for entry in distinct(entries):
        if entry.depth < 0.0 or (entry.depth == 0.0) != surface or entry.camera_height > MAX_HEIGHT_M:
            continue
        for box in entry.boxes:
            cx, cy = box[:2]
            edges = min(cx, cy, entry.width - cx, entry.height - cy)
            others = [
                max(abs(cx - x) - w / 2, abs(cy - y) - h / 2)
                for x, y, w, h in entry.boxes
                if (x, y, w, h) != box
            ]
            cutting = Cutting(entry, box, min([edges, *others, MAX_MINE_REACH_M]))
            if cutting.reach >= cutting.half + MINE_FEATHER_M and 2 * cutting.half <= MAX_BOX_M:
                found.append(cutting)
    return found


def choose_cuttings(
    entries: Sequence[Entry], surface_flags: Sequence[bool], spaces: Sequence[float], rng: np.random.Generator
) -> list[Cutting]:
    """One cutting for each mine, zones in turn so that a field shows several; `spaces` is the radius it may fill.

    Raises:
        BadInput: the set holds no suitable box.
    """
    chosen: list[Cutting] = []
    for surface, space in zip(surface_flags, spaces, strict=True):
        fitting = [
            c for c in cuttings(entries, surface) if c.half + MINE_FEATHER_M <= space and c not in chosen
        ]
        if not fitting:
            kind = "surface" if surface else "buried"
            raise BadInput(
                f"landmines: too few {kind} mines in pictures from 3 to {MAX_HEIGHT_M:g} m for this mission"
            )
        used = {
            zone: sum(c.entry.zone == zone for c in chosen)
            for zone in sorted({c.entry.zone for c in fitting})
        }
        rarest = [zone for zone, count in used.items() if count == min(used.values())]
        zone = rarest[int(rng.integers(len(rarest)))]
        of_zone = [c for c in fitting if c.entry.zone == zone]
        chosen.append(of_zone[int(rng.integers(len(of_zone)))])
    return chosen


def _turned(raster: NDArray[np.float32], turn: int) -> NDArray[np.float32]:
    """One of the eight mirrorings and quarter turns of a raster."""
    flipped = raster[:, ::-1] if turn & 4 else raster
    return np.rot90(flipped, turn & 3)


def lay_soil(
    data_dir: str | Path, entries: Sequence[Entry], grid: Grid, rng: np.random.Generator
) -> tuple[NDArray[np.float32], list[str]]:
    """Deviations in kelvin (rows, columns) from mine-free tiles, and the names of the pictures in use.

    Raises:
        BadInput: no picture shows enough soil without a mine.
    """
    res = grid.resolution
    side = math.ceil((TILE_M + 2 * FEATHER_M) / res)
    pitch = round(TILE_M / res)
    feather = side - pitch
    ramp = np.clip((np.arange(side) + 0.5) / feather, 0.0, 1.0)
    ramp = np.sin(0.5 * np.pi * np.minimum(ramp, ramp[::-1])) ** 2
    weight = np.outer(ramp, ramp).astype(np.float32)
    rows, columns = math.ceil(grid.rows / pitch) + 1, math.ceil(grid.columns / pitch) + 1
    total = np.zeros((rows * pitch + feather, columns * pitch + feather), dtype=np.float32)
    power = np.zeros_like(total)
    start_row, start_column = (int(value) for value in rng.integers(0, pitch, size=2))

    source = _SoilTiles(data_dir, entries, res, side, rng)
    for row in range(rows):
        for column in range(columns):
            window = (slice(row * pitch, row * pitch + side), slice(column * pitch, column * pitch + side))
            total[window] += weight * source.draw()
            power[window] += weight * weight
    # Cut so that every cell lies inside the lattice, at least a feather off its outer rim.
    start_row, start_column = max(feather, start_row), max(feather, start_column)
    start_row, start_column = (
        min(start_row, total.shape[0] - feather - grid.rows),
        min(start_column, total.shape[1] - feather - grid.columns),
    )
    cut = (slice(start_row, start_row + grid.rows), slice(start_column, start_column + grid.columns))
    return (total[cut] / np.sqrt(power[cut])).astype(np.float32), source.names


class _SoilTiles:
    """Draws square mine-free tiles, each picture once before any is used again.

    A picture without any box is left out: every zone is mined, so its mine has only not been labelled.
    """

    def __init__(
        self,
        data_dir: str | Path,
        entries: Sequence[Entry],
        resolution: float,
        side: int,
        rng: np.random.Generator,
    ) -> None:
        extent = side * resolution
        self._fitting = [
            entry
            for entry in distinct(entries)
            if entry.boxes and min(entry.width, entry.height) > extent and entry.camera_height <= MAX_HEIGHT_M
        ]
        if not self._fitting:
            raise BadInput(
                f"landmines: no picture from 3 to {MAX_HEIGHT_M:g} m covers {extent:.1f} m of ground"
            )
        self._data_dir, self._resolution, self._side, self._rng = data_dir, resolution, side, rng
        self._round: list[int] = []
        self._loaded: dict[str, NDArray[np.float32]] = {}
        self.names: list[str] = []

    def draw(self) -> NDArray[np.float32]:
        """The next tile, (side, side), kelvin."""
        for _ in range(2 * len(self._fitting) + 1):
            if not self._round:
                self._round = self._rng.permutation(len(self._fitting)).tolist()
            entry = self._fitting[self._round.pop()]
            tile = self._cut(entry)
            if tile is not None:
                if entry.name not in self.names:
                    self.names.append(entry.name)
                return _turned(tile, int(self._rng.integers(8)))
        raise BadInput("landmines: no picture shows enough ground without a labelled mine")

    def _cut(self, entry: Entry) -> NDArray[np.float32] | None:
        shape = (round(entry.height / self._resolution), round(entry.width / self._resolution))
        if min(shape) < self._side:
            return None
        free = outside_boxes(entry, self._resolution, shape, BOX_MARGIN_M)
        for _ in range(8):
            row = int(self._rng.integers(shape[0] - self._side + 1))
            column = int(self._rng.integers(shape[1] - self._side + 1))
            window = (slice(row, row + self._side), slice(column, column + self._side))
            if free[window].all():
                if entry.name not in self._loaded:
                    self._loaded[entry.name] = deviations(self._data_dir, entry, self._resolution)
                return self._loaded[entry.name][window]
        return None


def lay_cutting(
    raster: NDArray[np.float32],
    data_dir: str | Path,
    cutting: Cutting,
    grid: Grid,
    centre: Point,
    space: float,
    rng: np.random.Generator,
) -> None:
    """Blend a mine's own picture into `raster` (kelvin deviations) so that its box is centred, in place."""
    reach = min(cutting.reach, space)
    picture = deviations(data_dir, cutting.entry, grid.resolution)
    window = grid.window(centre, reach)
    dx, dy = grid.offsets(window, centre)
    turn = int(rng.integers(8))
    # Position in the picture of each cell: the mirrored and turned offset from the box's centre.
    across, down = np.broadcast_arrays(dx, dy)
    if turn & 4:
        across, down = down, across
    across, down = across * (-1 if turn & 1 else 1), down * (-1 if turn & 2 else 1)
    x, y = (cutting.box[0] + across) / grid.resolution, (cutting.box[1] + down) / grid.resolution
    columns = np.clip(x.astype(np.int64), 0, picture.shape[1] - 1)
    rows = np.clip(y.astype(np.int64), 0, picture.shape[0] - 1)
    # From 1 at the box to 0 at the reach, crooked in between: no circle shows that something was put here.
    feather = min(0.25, reach - cutting.half)
    inward = np.clip((reach - np.hypot(dx, dy)) / feather, 0.0, 1.0)
    local = Grid(0.0, 0.0, grid.resolution, inward.shape[1], inward.shape[0])
    crook = correlated_noise(local, 0.08, 1.2, rng)
    weight = np.sin(0.5 * np.pi * np.clip(inward + crook * inward * (1 - inward), 0.0, 1.0)) ** 2
    blended = raster[window] * (1 - weight) + picture[rows, columns] * weight
    raster[window] = blended / np.sqrt(weight**2 + (1 - weight) ** 2)


def measured_contrast(temperature: NDArray[np.float32], grid: Grid, centre: Point, half: float) -> float:
    """Median of the inner disc minus median of the ring around a box of half side `half` (m), K."""
    window = grid.window(centre, half + 0.10)
    distance = np.hypot(*grid.offsets(window, centre))
    inside = temperature[window][distance < max(0.03, 0.5 * half)]
    around = temperature[window][(distance > half + 0.02) & (distance < half + 0.10)]
    return float(np.median(inside) - np.median(around))
