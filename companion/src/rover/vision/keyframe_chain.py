"""Frames that stay: their features with their places on the ground, so that later frames can be placed by them.

Drift grows only with the number of keyframes between the launch and here, not with the way driven: a frame is placed by
the keyframe that was placed first of those that show enough of the same ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2

Points = NDArray[np.float64]


@dataclass(frozen=True)
class KeyframeSettings:
    """view_ahead: metres in front of base_link of the middle of the view. near: middles nearer than this overlap.

    new_after: a frame whose nearest keyframe is further becomes one. limit: how many are kept.
    """

    view_ahead: float = 0.5
    near: float = 0.32
    new_after: float = 0.18
    new_turn: float = 0.6
    limit: int = 400
    used: int = 2


@dataclass(frozen=True, eq=False)
class Keyframe:
    """signs: descriptors (N, 256) as ±1. points: (N, 2) on the ground in map. covariance: (3, 3) of its pose."""

    number: int
    pose: Pose2
    covariance: NDArray[np.float64]
    signs: NDArray[np.float32]
    points: Points
    middle: tuple[float, float]


class Keyframes:
    """All keyframes in the order in which they were placed."""

    def __init__(self, settings: KeyframeSettings) -> None:
        self._settings = settings
        self._frames: list[Keyframe] = []
        self._middles = np.empty((0, 2))

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self):
        return iter(self._frames)

    def add(self, pose: Pose2, covariance: NDArray[np.float64], signs: NDArray[np.float32], points: Points) -> None:
        """Keeps a frame; `points` are in map already. Does nothing once the limit is reached."""
        if len(self._frames) >= self._settings.limit:
            return
        middle = self._middle(pose)
        self._frames.append(Keyframe(len(self._frames), pose, covariance, signs, points, middle))
        self._middles = np.vstack([self._middles, middle])

    def overlapping(self, pose: Pose2) -> list[Keyframe]:
        """Keyframes whose view overlaps that of a pose: the one placed first, and the nearest."""
        distance = self._distances(pose)
        near = np.flatnonzero(distance < self._settings.near)
        if len(near) == 0:
            return []
        first, nearest = int(near[0]), int(near[np.argmin(distance[near])])
        return [self._frames[i] for i in dict.fromkeys((first, nearest))][: self._settings.used]

    def is_new(self, pose: Pose2) -> bool:
        """True when no keyframe shows about the same ground as a frame from this pose."""
        distance = self._distances(pose)
        return not bool((distance < self._settings.new_after).any())

    def _middle(self, pose: Pose2) -> tuple[float, float]:
        ahead = self._settings.view_ahead
        return pose.x + ahead * float(np.cos(pose.heading)), pose.y + ahead * float(np.sin(pose.heading))

    def _distances(self, pose: Pose2) -> NDArray[np.float64]:
        return np.linalg.norm(self._middles - self._middle(pose), axis=1)
