"""What stands off the ground, told by parallax: a flat place looks the same from everywhere, an upright thing does not.

All frames are laid on the ground plane (a plane sweep with the ground as its one plane: R. T. Collins, "A space-sweep
approach to true multi-image matching", CVPR 1996). Seen from the height z of the lens at distance d, what stands h high
is laid h·d/(z - h) too far out, and elsewhere from every other place: the temperatures that a cell gets disagree. Their
spread over viewpoints needs neither warmth nor an echo, only texture. Turning on the spot gives no parallax, and ground
that was seen from too few places, or has no texture, is not judged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.camera_view import CameraView, holds
from rover.mapping.rectangle import Rectangle
from rover.vision.camera.model import CameraModel

Mask = NDArray[np.bool_]
Point = tuple[float, float]

# Viewpoints nearer to each other than this tell nothing new, metres; and so many of them judge a cell.
VIEW_STEP = 0.04
LEAST_VIEWS = 4
# Beyond this range ahead what stands is laid so far out that it would blur the ground behind it, metres.
RANGE = 0.85
# Spread over viewpoints from which on a cell is not flat: in kelvin, and in that of the ground around, which tells what
# the pose errs by.
SPREAD_K = 0.30
SPREAD_RATIO = 2.5
# What is narrower than three cells is an edge, nothing that stands.
SMALLEST = np.ones((3, 3), np.uint8)
# Texture, kelvin, below which a stretch of ground looks the same wherever it is laid.
LEAST_TEXTURE_K = 0.06
# The window grows in steps of so many cells.
BLOCK = 64


@dataclass(frozen=True, eq=False)
class Judged:
    """Of a rectangle of the submap's lattice: cells that enough viewpoints have shown, and those of them that stand."""

    where: Rectangle
    judged: Mask
    standing: Mask


class Parallax:
    """What the frames of one submap have shown, in its frame: rasters over a window that grows with what is seen."""

    def __init__(self, resolution: float) -> None:
        self.resolution = resolution
        self._window = Rectangle(0, 0, 0, 0)
        self._views = np.zeros((0, 0), np.uint16)
        self._mean = np.zeros((0, 0), np.float32)
        self._squares = np.zeros((0, 0), np.float32)
        self._bears: Mask = np.zeros((0, 0), bool)
        self._view: CameraView | None = None
        self._last: Pose2 | None = None

    def integrate(
        self, frame: Frame, camera: CameraModel, pose: Pose2, mines: Sequence[Point] = (), reach: float = 0.0
    ) -> Judged | None:
        """One frame from `pose`; None when it was taken too near to the last one, or nothing can be judged.

        mines: places (x, y), metres; within `reach` of them a spread is that of a mine's edge.
        """
        if self._last is not None and math.hypot(pose.x - self._last.x, pose.y - self._last.y) < VIEW_STEP:
            return None
        self._last = pose
        if self._view is None or self._view.camera is not camera:
            self._view = CameraView(camera, 0.75 * self.resolution)
        near = (self._view.points[:, 0] <= RANGE) & holds(frame, self._view.maps)
        if not near.any():
            return None
        points = pose.transform(self._view.points[near].astype(np.float64))
        columns, rows = np.floor(points / self.resolution).astype(np.intp).T
        # The stub does not know that a map of two channels needs no second map.
        taken = cv2.remap(frame.kelvin(), self._view.maps[near], None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
        kelvin: NDArray[np.float32] = taken[:, 0]
        where = Rectangle.around(rows, columns)
        self._cover(where)
        self._add(where, rows - where.top, columns - where.left, kelvin)
        return self._judge(where, mines, reach)

    def _cover(self, where: Rectangle) -> None:
        """Grows the window so that it holds `where`."""
        if where.within(self._window) == where:
            return
        both = where if self._window.empty else where.joined(self._window)
        grown = Rectangle(
            both.top // BLOCK * BLOCK,
            both.left // BLOCK * BLOCK,
            -(-both.bottom // BLOCK) * BLOCK,
            -(-both.right // BLOCK) * BLOCK,
        )
        for name in ("_views", "_mean", "_squares", "_bears"):
            layer = getattr(self, name)
            larger = np.zeros(grown.shape, layer.dtype)
            if not self._window.empty:
                larger[self._window.slices(grown)] = layer
            setattr(self, name, larger)
        self._window = grown

    def _add(
        self, where: Rectangle, rows: NDArray[np.intp], columns: NDArray[np.intp], kelvin: NDArray[np.float32]
    ) -> None:
        """Welford's mean and sum of squares, a cell's points being one look."""
        at = where.slices(self._window)
        views, mean, squares = self._views[at], self._mean[at], self._squares[at]
        flat = rows * views.shape[1] + columns
        number = np.bincount(flat, minlength=views.size).reshape(views.shape)
        total = np.bincount(flat, kelvin, minlength=views.size).reshape(views.shape)
        seen = number > 0
        look = (total[seen] / number[seen]).astype(np.float32)
        before = views[seen]
        # The camera's offset drifts: a frame is put on the level of what is known of its ground.
        known = before > 1
        look -= np.float32(np.median((look - mean[seen])[known] if known.any() else look))
        views[seen] = before + 1
        step = look - mean[seen]
        mean[seen] += step / views[seen]
        squares[seen] += step * (look - mean[seen])

    def _judge(self, where: Rectangle, mines: Sequence[Point], reach: float) -> Judged | None:
        at = where.slices(self._window)
        views = self._views[at]
        enough = views >= LEAST_VIEWS
        if not enough.any():
            return None
        spread = np.sqrt(self._squares[at] / np.maximum(views - 1.0, 1.0))
        least = max(SPREAD_K, SPREAD_RATIO * float(np.median(spread[enough])))
        apart = (enough & (spread > least)).astype(np.uint8)
        standing = cv2.morphologyEx(apart, cv2.MORPH_OPEN, SMALLEST).astype(bool)
        for x, y in mines:
            standing &= ~self._in_disc(where, x, y, reach)
        return Judged(where, enough, standing)

    def bear(self, x: float, y: float, radius: float) -> None:
        """The hull has been here: nothing stands within `radius` of the point, metres."""
        where = self._around(x, y, radius)
        self._cover(where)
        self._bears[where.slices(self._window)] |= self._in_disc(where, x, y, radius)

    def is_judged(self, x: float, y: float, radius: float) -> bool:
        """Whether all ground within `radius` of the point was seen from enough places and has texture, or bears."""
        where = self._around(x, y, radius)
        if where.within(self._window) != where:
            return False
        at = where.slices(self._window)
        seen, bears = self._views[at] >= LEAST_VIEWS, self._bears[at]
        disc = self._in_disc(where, x, y, radius)
        if not (seen | bears | ~disc).all():
            return False
        return not (disc & ~bears).any() or float(np.std(self._mean[at][seen])) >= LEAST_TEXTURE_K

    def _around(self, x: float, y: float, radius: float) -> Rectangle:
        low = [math.floor((value - radius) / self.resolution) for value in (y, x)]
        high = [math.floor((value + radius) / self.resolution) + 1 for value in (y, x)]
        return Rectangle(low[0], low[1], high[0], high[1])

    def _in_disc(self, where: Rectangle, x: float, y: float, radius: float) -> Mask:
        """Cells of a rectangle whose centres lie in a disc."""
        dy = (np.arange(where.top, where.bottom) + 0.5)[:, None] * self.resolution - y
        dx = (np.arange(where.left, where.right) + 0.5)[None, :] * self.resolution - x
        return np.asarray(dx**2 + dy**2 <= radius**2)
