"""Keyframes: what the ground looked like from poses that are kept, and which of them to look at now.

The oldest keyframe that still overlaps is preferred: its pose has drifted least, so the error depends on where the
rover is and not on how far it has driven. Their number is bounded; the one most covered by others goes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.vision.camera import CameraModel

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Keyframe:
    """ground (N, 2): its features in base_link of its own pose; signs (N, 256): descriptors as -1 and +1;
    pixel_m (N,): ground covered by a pixel where each was seen; time: of exposure."""

    ground: Points
    signs: NDArray[np.float32]
    pixel_m: Points
    time: float


@dataclass(frozen=True)
class KeyframeSettings:
    """enough: a keyframe this much of whose view is shared may be used. sparse: below it a new one is due.

    limit: how many are kept. tries: how many are looked at for one frame.
    """

    enough: float = 0.45
    sparse: float = 0.65
    limit: int = 80
    tries: int = 2


@dataclass
class KeyframeStore:
    """All keyframes, oldest first; index i belongs to keyframe i of the filter's state."""

    camera: CameraModel
    settings: KeyframeSettings
    frames: list[Keyframe] = field(default_factory=list)

    def __post_init__(self) -> None:
        w, h = self.camera.width, self.camera.height
        v, u = np.mgrid[0:5, 0:6]
        uv = np.column_stack(((u.ravel() + 0.5) * w / 6.0, (v.ravel() + 0.5) * h / 5.0))
        ground = self.camera.pixel_to_ground(uv)
        self._samples = ground[np.isfinite(ground).all(axis=1)]

    def __len__(self) -> int:
        return len(self.frames)

    def overlap(self, pose: Points, others: Points) -> Points:
        """Share of the ground seen from `pose` (3,) that is also seen from each of `others` (K, 3); (K,)."""
        if len(others) == 0 or len(self._samples) == 0:
            return np.zeros(len(others))
        turn = pose[2] - others[:, 2]
        dx, dy = pose[0] - others[:, 0], pose[1] - others[:, 1]
        c, s = np.cos(others[:, 2]), np.sin(others[:, 2])
        shift_x, shift_y = c * dx + s * dy, -s * dx + c * dy
        ct, st = np.cos(turn)[:, None], np.sin(turn)[:, None]
        x = ct * self._samples[:, 0] - st * self._samples[:, 1] + shift_x[:, None]
        y = st * self._samples[:, 0] + ct * self._samples[:, 1] + shift_y[:, None]
        uv = self.camera.ground_to_pixel(np.column_stack((x.ravel(), y.ravel())))
        return self.camera.inside(uv).reshape(x.shape).mean(axis=1)

    def candidates(self, overlap: Points) -> list[int]:
        """Which keyframes to look at: the oldest that overlap enough, and last the one that overlaps most."""
        usable = np.flatnonzero(overlap >= self.settings.enough)
        if len(usable) == 0:
            return []
        chosen = usable[: self.settings.tries].tolist()
        best = int(usable[overlap[usable].argmax()])
        if best not in chosen:
            chosen[-1 if len(chosen) == self.settings.tries else len(chosen) :] = [best]
        return chosen

    def redundant(self, poses: Points) -> int:
        """The keyframe that another covers best, the newer of equals; never the first. poses: (K, 3)."""
        covered = np.zeros(len(poses))
        for index in range(1, len(poses)):
            others = self.overlap(poses[index], poses)
            others[index] = 0.0
            covered[index] = others.max()
        return len(poses) - 1 - int(covered[::-1].argmax())
