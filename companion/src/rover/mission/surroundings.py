"""Where the rover believes to be among the things around it: written down now, held against the truth afterwards."""

from __future__ import annotations

import math

import numpy as np

from rover.geometry import Pose2
from rover.mapping.survey_grid import NOBODY, SurveyGrid
from rover.mission.keepout import Zone
from rover.record.relative_error import RelativePose
from rover.vision.localization.localizer import Localizer

# What lies farther from the rover than this, metres, is not what it drives by.
WITHIN_M = 1.0


def among_things(pose: Pose2, localizer: Localizer, grid: SurveyGrid, zones: list[Zone]) -> RelativePose | None:
    """The rover's pose as seen from where the nearest zone or obstacle was seen; None where nothing is near."""
    found = _nearest(pose, grid, zones)
    if found is None:
        return None
    x, y, submap = found
    seen = localizer.as_seen_with((x, y), submap)
    if seen is None:
        return None
    time, inside, covariance = seen
    return RelativePose(localizer.time, time, inside, covariance)


def _nearest(pose: Pose2, grid: SurveyGrid, zones: list[Zone]) -> tuple[float, float, int] | None:
    """x, y in map of the nearest zone's centre or obstacle's cell, and the submap that it is shown from."""
    size, reach = grid.resolution, math.ceil(WITHIN_M / grid.resolution)
    row, column = math.floor(pose.y / size), math.floor(pose.x / size)
    top, left = max(row - reach, 0), max(column - reach, 0)
    window = np.s_[top : max(row + reach + 1, 0), left : max(column + reach + 1, 0)]
    rows, columns = np.nonzero(grid.occupied[window])
    things = np.column_stack(((columns + left + 0.5) * size, (rows + top + 0.5) * size))
    things = np.vstack((things, np.array([(zone.x, zone.y) for zone in zones]).reshape(-1, 2)))
    if not len(things):
        return None
    away = np.hypot(things[:, 0] - pose.x, things[:, 1] - pose.y)
    nearest = int(away.argmin())
    x, y = things[nearest].tolist()
    if away[nearest] > WITHIN_M:
        return None
    row, column = math.floor(y / size), math.floor(x / size)
    if not (0 <= row < grid.shape[0] and 0 <= column < grid.shape[1]) or grid.owner[row, column] == NOBODY:
        return None
    return x, y, int(grid.owner[row, column])
