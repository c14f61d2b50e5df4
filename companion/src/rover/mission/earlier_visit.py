"""An earlier survey of the same field, at another hour: what it reported is kept, and both are fused in the end.

The second visit begins at the launch as the first did; what it sees is its own. From the first it takes the places:
each keeps its number, and what was reported stays reported, so no wheel goes there. Once the drive is over, both
mosaics are laid on each other and asked together (`rover.detection.two_visits`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.place import PRIOR, Place
from rover.detection.second_look import LEAST_KNOWN
from rover.detection.two_visits import PlaceOfTwo, TwoVisits, compare
from rover.geometry import Pose2
from rover.mapping.local_grid import OCCUPIED
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.perception import Perception
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.localization.map_registration import LAUNCH_SIGMA_M, Registered, register_maps

Raster = NDArray[np.float32]

# A spot of both visits so near to a place is that place, metres; as far from what stands on the ground it is none.
SAME_M = 0.12
EDGE = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class EarlierVisit:
    """name: of the run's folder. kelvin: its mosaic in its own map, obstacles left out, nan where it saw nothing."""

    name: str
    hour: float
    keyframes: KeyframeMap
    kelvin: Raster
    places: tuple[Place, ...]


@dataclass(frozen=True, eq=False)
class Fused:
    """Both visits in the second one's map. said: of each indication, by its number."""

    earlier: EarlierVisit
    registered: Registered
    two: TwoVisits
    said: dict[int, PlaceOfTwo]


def take_over(visit: EarlierVisit, perception: Perception, next_place: int) -> None:
    """Its places, with their numbers: what it reported stays reported, but each is to be seen anew."""
    perception.evidence.restore([_unseen(place) for place in visit.places], next_place)
    for place in perception.evidence.places:
        place.judge(perception.evidence.settings)


def _unseen(place: Place) -> Place:
    """The place as an earlier visit leaves it: where it lies, about, and what was reported of it."""
    sigma = math.hypot(place.sigma_m, LAUNCH_SIGMA_M)
    reported = dict(place.p) if place.indication else place.earlier
    kept = Place(place.id, place.x, place.y, 0.0, 0.0, sigma, dict(PRIOR), extent=place.extent, earlier=reported)
    return replace(kept, _sums=np.array([place.x, place.y, 1.0, place.extent]) / sigma**2)


def fuse(visit: EarlierVisit, perception: Perception, hour: float, now: float) -> Fused:
    """Asks both together; what only they report is a new indication of `perception`, found after the drive."""
    grid = perception.grid
    here = plain(grid)
    registered = register_maps(
        visit.keyframes, visit.kelvin, perception.localizer.map, here, grid.resolution,
        any(plate.seen for plate in perception.markers.told(perception.localizer)),
    )  # fmt: skip
    there = moved(visit.kelvin, registered.shift, grid.resolution)
    two = compare(there, here, (visit.hour, hour), grid.resolution)
    known = perception.evidence.places
    for x, y, _ in two.spots().tolist():
        if not _may_tell(two, x, y) or any(math.hypot(place.x - x, place.y - y) <= SAME_M for place in known
                                           if place.indication):  # fmt: skip
            continue
        at = two.at(x, y)
        submap = int(grid.owner[int(y / grid.resolution), int(x / grid.resolution)])
        submap = min(submap, len(grid.pieces) - 1)
        near = [place for place in known if math.hypot(place.x - x, place.y - y) <= SAME_M]
        if near:
            closest = min(near, key=lambda place: math.hypot(place.x - x, place.y - y))
            closest.together = at.p
            closest.judge(perception.evidence.settings)
        else:
            sigma = math.hypot(perception.sigma, registered.residual_m)
            perception.evidence.report(x, y, sigma, now, submap, at.p)
    said = {place.id: two.at(place.x, place.y) for place in perception.indications}
    return Fused(visit, registered, two, said)


def _may_tell(two: TwoVisits, x: float, y: float) -> bool:
    """Whether both visits know the ground there: one alone has spoken for itself already."""
    at = two.at(x, y)
    return math.isfinite(at.first) and math.isfinite(at.second)


def plain(grid: SurveyGrid) -> Raster:
    """The mosaic without obstacles and their edges, whose warmth is none of the ground's."""
    solid = cv2.dilate((grid.thermal > OCCUPIED).astype(np.uint8), EDGE)
    return np.where(solid > 0, np.float32(np.nan), grid.temperature)


def moved(kelvin: Raster, shift: Pose2, resolution: float) -> Raster:
    """A mosaic laid where `shift` takes its map, on the same cells."""
    if shift == Pose2(0.0, 0.0, 0.0):
        return kelvin
    c, s = math.cos(shift.heading), math.sin(shift.heading)
    # Middles of cells lie at whole numbers of OpenCV's, at half a cell of ours.
    x = shift.x / resolution - 0.5 + 0.5 * (c - s)
    y = shift.y / resolution - 0.5 + 0.5 * (s + c)
    matrix = np.array([[c, -s, x], [s, c, y]])
    known = np.isfinite(kelvin)
    size = kelvin.shape[::-1]
    filled = np.where(known, kelvin, 0.0).astype(np.float32)
    value = cv2.warpAffine(filled, matrix, size, flags=cv2.INTER_LINEAR)
    share = cv2.warpAffine(known.astype(np.float32), matrix, size, flags=cv2.INTER_LINEAR)
    return np.where(share >= LEAST_KNOWN, value / np.maximum(share, LEAST_KNOWN), np.nan).astype(np.float32)
