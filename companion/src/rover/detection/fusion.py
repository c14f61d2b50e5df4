"""Many looks at the ground to places: what lies where, how sure, and how exactly.

Every look at a place adds to the log-probability of each class, weighed by how near it was and by how different its
viewpoint is from earlier ones: frames taken at rest repeat each other's errors. A place in clear view where nothing
like a mine is found any more loses probability in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.detection.detect import Detection
from rover.detection.place import Place
from rover.geometry import Pose2

NO_ANSWER = {"obstacle": 0.10, "surface": 0.06, "buried": 0.12, "background": 0.72}
"""What a look in clear view that found nothing says: most likely plain ground."""


@dataclass(frozen=True)
class EvidenceSettings:
    """report_threshold: probability of being a mine from which a place is an indication.

    suspect_threshold: the same for a suspected place. Distances in metres. The clear view is the part of base_link
    in which a mine would have been found: from clear_near to clear_far ahead, and `clear_side` + `clear_slope`·x
    to either side.
    """

    report_threshold: float = 0.5
    suspect_threshold: float = 0.25
    report_views: int = 4
    suspect_views: int = 2
    associate_within: float = 0.12
    create_from: float = 0.15
    near_range: float = 0.80
    far_weight: float = 0.5
    clear_near: float = 0.32
    clear_far: float = 0.92
    clear_side: float = 0.26
    clear_slope: float = 0.28
    shadow_half_width: float = 0.12


@dataclass
class Evidence:
    """Places found so far; deterministic in the order of the updates."""

    settings: EvidenceSettings = field(default_factory=EvidenceSettings)
    _places: list[Place] = field(default_factory=list)
    _next: int = 1

    @property
    def places(self) -> list[Place]:
        """Every place, oldest first."""
        return list(self._places)

    def update(
        self, detections: Sequence[Detection], pose: Pose2, covariance: NDArray[np.float64], time: float
    ) -> None:
        """The detections of one frame taken from `pose`; covariance (3, 3) of x, y, heading; time in seconds."""
        points = pose.transform(np.array([(d.x, d.y) for d in detections]).reshape(-1, 2))
        taken: set[int] = set()
        for place in self._places:
            index = self._match(place, detections, points)
            if index is not None:
                taken.add(index)
                found, at = detections[index], points[index]
                place.add(found, at, pose, self._weight(found.x, found.y), _variance(found, covariance), time)
            elif self._in_clear_view(place, detections, pose):
                local = pose.inverse().transform(np.array([[place.x, place.y]]))[0]
                place.miss(NO_ANSWER, pose, self._weight(*local))
        for index, found in enumerate(detections):
            if index not in taken and found.p["surface"] + found.p["buried"] >= self.settings.create_from:
                self._create(found, points[index], pose, covariance, time)
        self._merge()
        for place in self._places:
            place.judge(self.settings)
        self._places = [place for place in self._places if not place.is_spent]

    def _match(self, place: Place, detections: Sequence[Detection], points: NDArray[np.float64]) -> int | None:
        """The detection that is this place: the nearest, where likeness to a mine is worth some distance."""
        best, least = None, math.inf
        for index, (found, point) in enumerate(zip(detections, points, strict=True)):
            distance = math.hypot(point[0] - place.x, point[1] - place.y)
            if distance > self.settings.associate_within:
                continue
            score = distance - 0.06 * (1.0 - found.p["background"])
            if score < least:
                best, least = index, score
        return best

    def _create(
        self, found: Detection, at: NDArray[np.float64], pose: Pose2, covariance: NDArray[np.float64], time: float
    ) -> None:
        if any(math.hypot(at[0] - p.x, at[1] - p.y) <= self.settings.associate_within for p in self._places):
            return
        place = Place(self._next, float(at[0]), float(at[1]), first_seen=time, last_seen=time)
        self._next += 1
        place.add(found, at, pose, self._weight(found.x, found.y), _variance(found, covariance), time)
        self._places.append(place)

    def _weight(self, x: float, y: float) -> float:
        return 1.0 if math.hypot(x, y) < self.settings.near_range else self.settings.far_weight

    def _in_clear_view(self, place: Place, detections: Sequence[Detection], pose: Pose2) -> bool:
        """True when a mine there would have been found: well inside the picture and behind no obstacle."""
        s = self.settings
        x, y = pose.inverse().transform(np.array([[place.x, place.y]]))[0].tolist()
        if not (s.clear_near <= x <= s.clear_far and abs(y) <= s.clear_side + s.clear_slope * x):
            return False
        reach = math.hypot(x, y)
        for other in detections:
            if other.p["obstacle"] < 0.5 or math.hypot(other.x, other.y) > reach + 0.05:
                continue
            if abs(x * other.y - y * other.x) / reach < s.shadow_half_width + 0.5 * other.extent:
                return False
        return True

    def _merge(self) -> None:
        """Of two places that have come together the better known keeps its number."""
        for place in sorted(self._places, key=lambda p: (-p.views, p.id)):
            if place not in self._places:
                continue
            for other in list(self._places):
                near = math.hypot(other.x - place.x, other.y - place.y) < 0.6 * self.settings.associate_within
                if other is not place and near:
                    place.absorb(other)
                    self._places.remove(other)


def _variance(found: Detection, covariance: NDArray[np.float64]) -> tuple[float, float]:
    """Variances (m²) of a detection's position: what each look errs by alone, and what the pose gives to all."""
    reach = math.hypot(found.x, found.y)
    own = (0.008 + 0.012 * reach) ** 2
    pose = 0.5 * float(covariance[0, 0] + covariance[1, 1]) + float(covariance[2, 2]) * reach**2
    return own, pose
