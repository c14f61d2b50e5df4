"""Marker plates at surveyed places: seen, they tie the rover's map to the area's frame.

A plate is neither an indication nor an obstacle: it is taken out of the picture before anything else looks at it. No
wheel goes over one that has been seen, for a plate that has been shifted tells wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mission.config import Plates
from rover.mission.keepout import Zone
from rover.vision.camera.model import CameraModel
from rover.vision.localization.cold_plate import ColdSpot, cold_spots, colder
from rover.vision.localization.localizer import Localizer

# A spot is taken for the nearest plate when it lies within so many 1σ of the rover's place in map of it, and this much
# more, metres: what the place is believed to err by may be wrong, too.
SIGMAS, REACH_M = 4.0, 0.3
# And when any other plate is so many times farther away.
APART = 2.0


@dataclass(frozen=True)
class PlateSeen:
    """What became of one plate. off: how far from its place the map had it when it was seen first, metres.

    off is None for a plate that was not seen, or not in this run.
    """

    x: float
    y: float
    seen: bool
    off: float | None


class Markers:
    """The plates of one mission."""

    def __init__(self, plates: Plates, camera: CameraModel, hour: float) -> None:
        self._plates, self._camera = plates, camera
        self._colder_k = colder(hour)
        self._off: dict[int, float] = {}

    def find(self, frame: Frame) -> list[ColdSpot]:
        """What in a frame may be a plate."""
        if not self._plates.places or frame.ffc:
            return []
        return cold_spots(frame, self._camera, self._plates.side, self._colder_k)

    def recognised(self, spots: list[ColdSpot], pose: Pose2, sigma: float) -> list[tuple[int, ColdSpot]]:
        """The spots that are plates, with their numbers; pose, sigma: of the rover in map, 1σ in metres."""
        found = []
        for spot in spots:
            x, y = pose.transform(np.array([[spot.x, spot.y]]))[0].tolist()
            away = sorted((math.hypot(px - x, py - y), number) for number, (px, py) in enumerate(self._plates.places))
            nearest, number = away[0]
            if nearest <= REACH_M + SIGMAS * sigma and (len(away) == 1 or away[1][0] >= APART * nearest):
                found.append((number, spot))
        return found

    def tie(self, found: list[tuple[int, ColdSpot]], pose: Pose2, localizer: Localizer) -> None:
        """Ties the map to the plates in full view of a frame that the localizer has just taken; pose: then, in map."""
        for number, spot in found:
            if not spot.whole:
                continue
            known = self._plates.places[number]
            if number not in self._off:
                x, y = pose.transform(np.array([[spot.x, spot.y]]))[0].tolist()
                self._off[number] = math.hypot(known[0] - x, known[1] - y)
            localizer.tie((spot.x, spot.y), spot.sigma, known)

    def zones(self, localizer: Localizer) -> list[Zone]:
        """Where no wheel goes: the plates that have been seen, where the map has them now."""
        graph, radius = localizer.atlas.graph, self._plates.radius
        zones = []
        for number, place in enumerate(self._plates.places):
            ties = [tie for tie in graph.ties if tie.known == place]
            if ties:
                best = min(ties, key=lambda tie: float(tie.covariance.trace()))
                x, y = graph.poses[best.submap].transform(np.array([best.seen]))[0].tolist()
                zones.append(Zone(-1 - number, x, y, radius, 0.0))
        return zones

    def told(self, localizer: Localizer) -> tuple[PlateSeen, ...]:
        """What became of every plate, in the order of the mission file."""
        tied = {tie.known for tie in localizer.atlas.graph.ties}
        return tuple(
            PlateSeen(place[0], place[1], place in tied, self._off.get(number))
            for number, place in enumerate(self._plates.places)
        )
