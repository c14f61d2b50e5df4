"""Many looks at the ground to places: what lies where, how sure, and how exactly.

Every look at a place adds to the log-probability of each class, weighed by how near it was and by how different its
viewpoint is from earlier ones: frames taken at rest repeat each other's errors. A place in clear view where nothing
like a mine is found any more loses probability in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.ground.detect import Detection
from rover.detection.place import Anchor, Place
from rover.geometry import Pose2

# What a look in clear view that found nothing says: most likely plain ground.
NO_ANSWER = {"obstacle": 0.07, "surface": 0.03, "buried": 0.05, "background": 0.85}


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

    @property
    def next_place(self) -> int:
        """The number of the next new place."""
        return self._next

    def restore(self, places: Sequence[Place], next_place: int) -> None:
        """Takes over what another run has found; numbers go on from there."""
        self._places, self._next = list(places), next_place

    def report(self, x: float, y: float, sigma: float, time: float, submap: int, together: float) -> Place:
        """A new place that no look by itself has found, but the temperatures of two visits together."""
        place = Place(self._next, x, y, time, time, sigma, submap=submap, together=together)
        self._next += 1
        place.judge(self.settings)
        self._places.append(place)
        return place

    def move(self, shifts: Mapping[int, Pose2]) -> None:
        """Submaps have moved in map, by number; what was seen from them moves with them."""
        for place in self._places:
            if place.submap in shifts:
                place.move(shifts[place.submap])

    def update(
        self,
        detections: Sequence[Detection],
        pose: Pose2,
        covariance: NDArray[np.float64],
        time: float,
        submap: int = 0,
    ) -> None:
        """The detections of one frame taken from `pose`; covariance (3, 3) of x, y, heading; time in seconds.

        submap: the one that the rover is in.
        """
        for place in self._places:
            if place.anchor is None:  # of an earlier run: what holds it is where this one has found itself
                place.anchor = Anchor(time, pose)
        points = pose.transform(np.array([(d.x, d.y) for d in detections]).reshape(-1, 2))
        centres = np.array([(p.x, p.y) for p in self._places]).reshape(-1, 2)
        local = pose.inverse().transform(centres)
        clear = self._in_clear_view(local, detections)
        matches = self._matches(centres, detections, points)
        for place, index, at_base, in_view in zip(self._places, matches, local.tolist(), clear, strict=True):
            if index >= 0:
                found = detections[index]
                weight = self._weight(found.x, found.y)
                place.add(found, points[index], pose, weight, _variance(found, covariance), time, submap)
            elif in_view:
                place.miss(NO_ANSWER, pose, self._weight(*at_base))
        taken = set(matches)
        for index, found in enumerate(detections):
            if index not in taken and found.p["surface"] + found.p["buried"] >= self.settings.create_from:
                self._create(found, points[index], pose, covariance, time, submap)
        self._merge()
        for place in self._places:
            place.judge(self.settings)
        self._places = [place for place in self._places if not place.is_spent]

    def _matches(
        self, centres: NDArray[np.float64], detections: Sequence[Detection], points: NDArray[np.float64]
    ) -> list[int]:
        """For every place its detection, -1 for none: the nearest, where being no background is worth some distance."""
        if not len(centres) or not detections:
            return [-1] * len(centres)
        distance = np.hypot(centres[:, None, 0] - points[None, :, 0], centres[:, None, 1] - points[None, :, 1])
        bonus = np.array([0.06 * (1.0 - found.p["background"]) for found in detections])
        score = np.where(distance <= self.settings.associate_within, distance - bonus, np.inf)
        best = score.argmin(axis=1)
        return [int(index) for index in np.where(np.isfinite(score.min(axis=1)), best, -1)]

    def _create(
        self,
        found: Detection,
        at: NDArray[np.float64],
        pose: Pose2,
        covariance: NDArray[np.float64],
        time: float,
        submap: int,
    ) -> None:
        if any(math.hypot(at[0] - p.x, at[1] - p.y) <= self.settings.associate_within for p in self._places):
            return
        place = Place(self._next, float(at[0]), float(at[1]), first_seen=time, last_seen=time)
        self._next += 1
        place.add(found, at, pose, self._weight(found.x, found.y), _variance(found, covariance), time, submap)
        self._places.append(place)

    def _weight(self, x: float, y: float) -> float:
        return 1.0 if math.hypot(x, y) < self.settings.near_range else self.settings.far_weight

    def _in_clear_view(self, local: NDArray[np.float64], detections: Sequence[Detection]) -> NDArray[np.bool_]:
        """Where, of points (N, 2) in base_link, a mine would have been found: in the picture, behind no obstacle."""
        s = self.settings
        x, y = local[:, 0], local[:, 1]
        clear = (s.clear_near <= x) & (x <= s.clear_far) & (np.abs(y) <= s.clear_side + s.clear_slope * x)
        reach = np.maximum(np.hypot(x, y), 1e-6)
        for other in detections:
            if other.p["obstacle"] >= 0.5:
                behind = reach + 0.05 >= math.hypot(other.x, other.y)
                across = np.abs(x * other.y - y * other.x) / reach
                clear &= ~(behind & (across < s.shadow_half_width + 0.5 * other.extent))
        return clear

    def _merge(self) -> None:
        """Of two places that have come together the better known keeps its number."""
        if len(self._places) < 2:
            return
        limit = 0.6 * self.settings.associate_within
        x, y = np.array([(p.x, p.y) for p in self._places]).T
        pairs = np.argwhere(np.triu(np.hypot(x[:, None] - x, y[:, None] - y) < limit, 1)).tolist()
        gone: set[int] = set()
        for a, b in pairs:
            if a in gone or b in gone:
                continue
            first, second = self._places[a], self._places[b]
            ranks = [(place.earlier is not None, place.views, -place.id) for place in (first, second)]
            keep, drop = (a, b) if ranks[0] >= ranks[1] else (b, a)
            self._places[keep].absorb(self._places[drop])
            gone.add(drop)
        self._places = [place for index, place in enumerate(self._places) if index not in gone]


def _variance(found: Detection, covariance: NDArray[np.float64]) -> tuple[float, float]:
    """Variances (m²) of a detection's position: what each look errs by alone, and what the pose gives to all."""
    reach = math.hypot(found.x, found.y)
    own = (0.008 + 0.012 * reach) ** 2
    pose = 0.5 * float(covariance[0, 0] + covariance[1, 1]) + float(covariance[2, 2]) * reach**2
    return own, pose
