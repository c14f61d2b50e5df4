"""How much of the ground that could be seen was seen, by the truth alone.

What could be seen: ground in the camera's reach, with no obstacle between, from a pose that the rover can reach past
the true obstacles and the true mines, each with the mission's keep-out radius. The reach and the way are those of
`rover.mission.freespace` and of the camera's view; nothing of the companion's maps is read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.mapping.camera_view import MAX_SEEN_RANGE
from rover.mission.area_masks import entered, wanted
from rover.mission.config import Mission
from rover.mission.freespace import MARGIN, core_radius, disc_mask, eroded
from rover.mission.targets import START_ESCAPE
from rover.mission.visible import visible_from

from rover_hil.ground import Ground

Mask = NDArray[np.bool_]

CELL = 0.02
SEEN_CELL = 0.01
"""Of the plant's raster of seen ground, which reaches SEEN_MARGIN beyond the area."""
SEEN_MARGIN = 0.5


def judge_coverage(mission: Mission, ground: Ground, seen: Mask) -> dict[str, Any]:
    """`seen`: what the camera's rays have hit, the plant's raster (rows, columns). coverage: 0 to 1, of visible_m2."""
    shape = (math.ceil(mission.area.height / CELL - 1e-9), math.ceil(mission.area.width / CELL - 1e-9))
    obstacles = _discs(shape, ground.obstacles[:, :3].tolist())
    obstacles |= _discs(shape, mission.area.obstacles)
    visible = visible_ground(mission, shape, obstacles, [(mine.x, mine.y) for mine in ground.mines])
    share = np.where(visible, _share_seen(seen, shape), 0.0)
    area = float(visible.sum()) * CELL**2
    covered = float(share.sum()) * CELL**2
    return {"coverage": covered / area if area > 0.0 else 1.0, "visible_m2": area}


def visible_ground(
    mission: Mission, shape: tuple[int, int], obstacles: Mask, mines: Sequence[tuple[float, float]]
) -> Mask:
    """Cells (rows, columns) of the area to survey that a careful rover, which spares plates, can bring into view."""
    vehicle, launch = mission.rover.vehicle, mission.launch
    core = core_radius(mission.detector.keepout_radius, vehicle)
    blocked = obstacles | _discs(shape, [(x, y, core) for x, y in mines])
    off_plates = core_radius(mission.plates.radius, vehicle)
    blocked |= _discs(shape, [(x, y, off_plates) for x, y in mission.plates.places])
    blocked |= ~entered(mission.area, launch, shape, CELL)
    reached = _reached(blocked, vehicle.radius + MARGIN, (launch.pose.x, launch.pose.y))
    found = visible_from(reached, obstacles, MAX_SEEN_RANGE, CELL)
    ground: Mask = wanted(mission.area, shape, CELL) & ~obstacles
    launched = disc_mask(shape, CELL, launch.pose.x, launch.pose.y, launch.surveyed_radius)
    return ground & (found | launched)


def _reached(blocked: Mask, radius: float, start: tuple[float, float]) -> Mask:
    """Where a disc can go from the start without touching what is blocked, or the border."""
    free = eroded(blocked, CELL, radius)
    _, labels = cv2.connectedComponents(free.astype(np.uint8), connectivity=8)
    rows, columns = np.nonzero(free)
    away = np.hypot((rows + 0.5) * CELL - start[1], (columns + 0.5) * CELL - start[0])
    if not away.size or away.min() > START_ESCAPE:
        return np.zeros_like(blocked)
    nearest = int(np.argmin(away))
    return np.asarray(labels == labels[rows[nearest], columns[nearest]]) & free


def _share_seen(seen: Mask, shape: tuple[int, int]) -> NDArray[np.float64]:
    """The plant's raster in cells of CELL: the share of each that was seen."""
    margin, ratio = round(SEEN_MARGIN / SEEN_CELL), round(CELL / SEEN_CELL)
    inner = seen[margin : margin + shape[0] * ratio, margin : margin + shape[1] * ratio]
    whole = np.zeros((shape[0] * ratio, shape[1] * ratio))
    whole[: inner.shape[0], : inner.shape[1]] = inner
    cells: NDArray[np.float64] = whole.reshape(shape[0], ratio, shape[1], ratio).mean(axis=(1, 3))
    return cells


def _discs(shape: tuple[int, int], circles: Sequence[Sequence[float]]) -> Mask:
    mask = np.zeros(shape, bool)
    for x, y, radius in circles:
        mask |= disc_mask(shape, CELL, x, y, radius)
    return mask
