"""Keyframes: what the ground looked like from poses that are kept, and which of them to look at now.

The oldest keyframe that still overlaps is preferred: its pose has drifted least, so the error depends on where the
rover is and not on how far it has driven.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.vision.camera.model import CameraModel
from rover.vision.registration.matching import BITS, signs

Points = NDArray[np.float64]


# The time of a keyframe that another run has left: seconds of another clock mean nothing.
OF_ANOTHER_RUN = -1.0


@dataclass(frozen=True, eq=False)
class Keyframe:
    """ground (N, 2): its features in base_link of its own pose; descriptors (N, 32) of these;
    pixel_m (N,): ground covered by a pixel where each was seen; time: of exposure."""

    ground: Points
    descriptors: NDArray[np.uint8]
    pixel_m: Points
    time: float


@dataclass(frozen=True)
class KeyframeSettings:
    """enough: a keyframe this much of whose view is shared may be used. sparse: below it a new one is due.

    limit: how many one submap holds. tries: how many are looked at for one frame.
    """

    enough: float = 0.45
    sparse: float = 0.65
    limit: int = 80
    tries: int = 2


@dataclass
class KeyframeStore:
    """All keyframes of a submap, oldest first; index i belongs to keyframe i of its filter's state."""

    camera: CameraModel
    settings: KeyframeSettings
    frames: list[Keyframe] = field(default_factory=list)

    def __post_init__(self) -> None:
        w, h = self.camera.width, self.camera.height
        v, u = np.mgrid[0:5, 0:6]
        uv = np.column_stack(((u.ravel() + 0.5) * w / 6.0, (v.ravel() + 0.5) * h / 5.0))
        ground = self.camera.pixel_to_ground(uv)
        self._samples = ground[np.isfinite(ground).all(axis=1)]
        self._stacked: tuple[list[Keyframe], NDArray[np.float32], NDArray[np.intp]] | None = None

    def __len__(self) -> int:
        return len(self.frames)

    def votes(self, asked: NDArray[np.uint8], bits: float) -> NDArray[np.intp]:
        """How many descriptors (N, 32) have their nearest of all in each keyframe, within `bits`; (K,)."""
        # Stacked anew only when keyframes have come: most frames never ask.
        if self._stacked is None or len(self._stacked[0]) != len(self.frames):
            owner = np.repeat(np.arange(len(self.frames)), [len(frame.descriptors) for frame in self.frames])
            everything = signs(np.concatenate([frame.descriptors for frame in self.frames]))
            self._stacked = (list(self.frames), everything, owner)
        _, everything, owner = self._stacked
        agreement = signs(asked) @ everything.T
        nearest = agreement.argmax(axis=1)
        close = agreement[np.arange(len(asked)), nearest] >= BITS - 2.0 * bits
        return np.bincount(owner[nearest[close]], minlength=len(self.frames))

    def add(self, frame: Keyframe) -> None:
        """Appends a keyframe."""
        self.frames.append(frame)

    def forget_votes(self) -> None:
        """Frees what `votes` has stacked up: 30 MB for a full submap."""
        self._stacked = None

    def overlap(self, pose: Points, others: Points) -> Points:
        """Share of the ground seen from `pose` (3,) that is also seen from each of `others` (K, 3); (K,)."""
        return self._overlap(np.repeat(pose[None, :], len(others), axis=0), others)

    def _overlap(self, poses: Points, others: Points) -> Points:
        """The same for pairs: (K, 3) and (K, 3) to (K,)."""
        if len(others) == 0 or len(self._samples) == 0:
            return np.zeros(len(others))
        turn = poses[:, 2] - others[:, 2]
        dx, dy = poses[:, 0] - others[:, 0], poses[:, 1] - others[:, 1]
        c, s = np.cos(others[:, 2]), np.sin(others[:, 2])
        shift_x, shift_y = c * dx + s * dy, -s * dx + c * dy
        ct, st = np.cos(turn)[:, None], np.sin(turn)[:, None]
        x = ct * self._samples[:, 0] - st * self._samples[:, 1] + shift_x[:, None]
        y = st * self._samples[:, 0] + ct * self._samples[:, 1] + shift_y[:, None]
        uv = self.camera.ground_to_pixel(np.column_stack((x.ravel(), y.ravel())))
        share: Points = self.camera.inside(uv).reshape(x.shape).mean(axis=1)
        return share

    def first_with(self, point: tuple[float, float], poses: Points) -> int | None:
        """The first keyframe of this run that shows a point; poses (K, 3): theirs, in the frame of the point."""
        dx, dy = point[0] - poses[:, 0], point[1] - poses[:, 1]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        uv = self.camera.ground_to_pixel(np.column_stack((c * dx + s * dy, c * dy - s * dx)))
        ours = np.array([frame.time for frame in self.frames]) != OF_ANOTHER_RUN
        shows = np.flatnonzero(self.camera.inside(uv) & ours)
        return int(shows[0]) if len(shows) else None

    def candidates(self, overlap: Points) -> list[int]:
        """Which keyframes to look at: the oldest that overlap enough, and last the one that overlaps most."""
        usable = np.flatnonzero(overlap >= self.settings.enough)
        if len(usable) == 0:
            return []
        chosen = [int(index) for index in usable[: self.settings.tries]]
        best = int(usable[overlap[usable].argmax()])
        if best not in chosen:
            chosen[-1 if len(chosen) == self.settings.tries else len(chosen) :] = [best]
        return chosen
