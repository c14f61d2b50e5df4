"""Next best views: where the rover should stand and look so that unseen ground comes into the camera's picture.

Grids are (rows, columns), row 0 at the origin's y, one cell `resolution` metres wide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import rover_native
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ViewpointSettings:
    """How views are sampled and weighed."""

    positions: int = 300
    headings: int = 16
    minimum_gain_m2: float = 0.002
    count: int = 12  # how many views are returned
    speed: float = 0.2  # m/s, to weigh the way there
    turn_rate: float = 0.8  # rad/s
    overhead_s: float = 2.5  # starting, stopping and looking


@dataclass(frozen=True)
class Viewpoint:
    """A pose to look from, the unseen ground that it shows in m², and the way there in metres."""

    pose: Pose2
    gain_m2: float
    distance: float


def cell_of(
    x: float, y: float, resolution: float, origin: tuple[float, float], shape: tuple[int, int]
) -> tuple[int, int]:
    """(column, row) of the cell that holds a point. Raises BadInput outside the grid."""
    column = math.floor((x - origin[0]) / resolution)
    row = math.floor((y - origin[1]) / resolution)
    if not (0 <= column < shape[1] and 0 <= row < shape[0]):
        raise BadInput(f"the point ({x:g}, {y:g}) lies outside the grid of {shape[1]} × {shape[0]} cells")
    return column, row


def distance_field(
    free: Mask,
    start: tuple[float, float],
    resolution: float,
    origin: tuple[float, float] = (0.0, 0.0),
    *,
    snap: float = 0.0,
) -> NDArray[np.float32]:
    """Travel distance in metres from `start` over free cells (8-connected), infinite where there is no way.

    With `snap` a start on a cell that is not free begins at the nearest free cell within that distance.
    Raises BadInput when the start lies outside the grid.
    """
    column, row = cell_of(start[0], start[1], resolution, origin, free.shape)
    if snap > 0.0 and not free[row, column]:
        reach = math.ceil(snap / resolution)
        top, left = max(row - reach, 0), max(column - reach, 0)
        rows, columns = np.nonzero(free[top : row + reach + 1, left : column + reach + 1])
        if rows.size:
            squared = (rows + top - row) ** 2 + (columns + left - column) ** 2
            nearest = int(np.argmin(squared))
            if squared[nearest] <= reach * reach:
                row, column = int(rows[nearest]) + top, int(columns[nearest]) + left
    blocked = np.ascontiguousarray(~free).view(np.uint8)
    return rover_native.distance_field(blocked, (column, row), resolution)


def viewpoints(
    seen: Mask,
    free: Mask,
    area: Mask,
    footprint: NDArray[np.float64],
    pose: Pose2,
    resolution: float,
    distance: NDArray[np.float32],
    settings: ViewpointSettings | None = None,
    *,
    occluders: Mask | None = None,
    origin: tuple[float, float] = (0.0, 0.0),
) -> list[Viewpoint]:
    """The best views, best first: unseen cells of `area` in the camera's `footprint` per second of travel.

    `free`: where the robot's centre may be; `footprint`: convex polygon (N, 2) on the ground in base_link;
    `distance`: from `distance_field`; `occluders`: cells that hide what lies behind them. Positions lie on a lattice
    over the reachable free cells from which unseen ground is near; the same arguments give the same list.
    """
    settings = settings or ViewpointSettings()
    unseen = np.ascontiguousarray(area & ~seen)
    reachable = free & np.isfinite(distance)
    reach = float(np.linalg.norm(footprint, axis=1).max())
    cells = _positions(unseen, reachable, reach / resolution, settings.positions, pose, resolution, origin)
    if cells.size == 0:
        return []
    headings = -math.pi + 2.0 * math.pi * np.arange(settings.headings) / settings.headings
    polygon = np.ascontiguousarray(footprint, dtype=np.float64)
    camera = _camera(polygon.tobytes(), settings.headings, resolution)
    travel = distance[cells[:, 1], cells[:, 0]].astype(np.float64)
    x = origin[0] + (cells[:, 0] + 0.5) * resolution
    y = origin[1] + (cells[:, 1] + 0.5) * resolution
    turns = _turns(pose, x, y, travel, headings)
    seconds = settings.overhead_s + travel[:, None] / settings.speed + turns / settings.turn_rate
    counts = camera.open_gains(unseen.view(np.uint8), cells)
    if occluders is not None and occluders.any():
        counts = _hide(camera, unseen, np.ascontiguousarray(occluders), cells, counts, seconds, settings.count)
    gains = counts.astype(np.float64) * resolution**2
    score = np.where(gains >= settings.minimum_gain_m2, gains / seconds, 0.0)
    # One view per position, or the list is sixteen times the same place.
    best_heading = np.argmax(score, axis=1)
    best_score = score[np.arange(len(cells)), best_heading]
    chosen = [int(i) for i in np.argsort(-best_score, kind="stable")[: settings.count] if best_score[i] > 0.0]
    return [
        Viewpoint(
            Pose2(float(x[i]), float(y[i]), float(headings[best_heading[i]])),
            float(gains[i, best_heading[i]]),
            float(travel[i]),
        )
        for i in chosen
    ]


@lru_cache(maxsize=8)
def _camera(footprint: bytes, headings: int, resolution: float) -> rover_native.Views:
    polygon = np.frombuffer(footprint, dtype=np.float64).reshape(-1, 2)
    angles = -math.pi + 2.0 * math.pi * np.arange(headings) / headings
    return rover_native.Views(polygon, angles, resolution)


def _hide(
    camera: rover_native.Views,
    unseen: Mask,
    occluders: Mask,
    cells: NDArray[np.int32],
    counts: NDArray[np.uint32],
    seconds: NDArray[np.float64],
    wanted: int,
) -> NDArray[np.uint32]:
    """Counts (positions, headings) with hidden cells taken off, for the views that can be among the best.

    What is seen with nothing hidden bounds what is seen from above: views are looked at in the order of that
    bound until `wanted` positions are better than any view left; those left count nothing.
    """
    bound = (counts / seconds).ravel()
    order = np.argsort(-bound, kind="stable")
    true = np.zeros(counts.size, dtype=np.uint32)
    best = np.zeros(len(cells))
    for first in range(0, order.size, 256):
        batch = order[first : first + 256]
        if bound[batch[0]] <= 0.0 or np.sort(best)[-wanted:][0] >= bound[batch[0]]:
            break
        place, heading = np.divmod(batch, counts.shape[1])
        views = np.column_stack([cells[place], heading]).astype(np.int32)
        true[batch] = camera.gains(unseen.view(np.uint8), occluders.view(np.uint8), views)
        np.maximum.at(best, place, true[batch] / seconds.ravel()[batch])
    return true.reshape(counts.shape)


def _positions(
    unseen: Mask,
    reachable: Mask,
    reach_cells: float,
    wanted: int,
    pose: Pose2,
    resolution: float,
    origin: tuple[float, float],
) -> NDArray[np.int32]:
    """Reachable cells (N, 2) as column, row within reach of unseen ground, on a lattice of about `wanted`."""
    rows, columns = unseen.shape
    sums = np.zeros((rows + 1, columns + 1), dtype=np.int64)
    sums[1:, 1:] = unseen.cumsum(axis=0, dtype=np.int64).cumsum(axis=1)
    reach = math.ceil(reach_cells)
    row, column = np.nonzero(reachable)
    top, bottom = np.clip(row - reach, 0, rows), np.clip(row + reach + 1, 0, rows)
    left, right = np.clip(column - reach, 0, columns), np.clip(column + reach + 1, 0, columns)
    near = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left] > 0
    row, column = row[near], column[near]
    stride = max(1, math.ceil(math.sqrt(row.size / max(wanted, 1))))
    keep = (row % stride == stride // 2) & (column % stride == stride // 2)
    if not keep.any():
        keep[:: max(1, row.size // max(wanted, 1))] = True
    here_column = math.floor((pose.x - origin[0]) / resolution)
    here_row = math.floor((pose.y - origin[1]) / resolution)
    keep |= (row == here_row) & (column == here_column)  # turning where it stands is often the best
    return np.ascontiguousarray(np.stack([column[keep], row[keep]], axis=1), dtype=np.int32)


def _turns(
    pose: Pose2,
    x: NDArray[Any],
    y: NDArray[Any],
    travel: NDArray[Any],
    headings: NDArray[Any],
) -> NDArray[np.float64]:
    """Radians (positions, headings) turned on the way: towards the place, then to the heading there."""
    bearing = np.arctan2(y - pose.y, x - pose.x)
    stays = travel < 1e-3

    def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.abs((angle + math.pi) % (2.0 * math.pi) - math.pi)

    there = np.where(stays, 0.0, wrapped(bearing - pose.heading))
    arrived = np.where(stays, wrap_angle(pose.heading), bearing)
    return there[:, None] + wrapped(headings[None, :] - arrived[:, None])
