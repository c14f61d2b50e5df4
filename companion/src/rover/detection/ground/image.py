"""A thermal picture laid out on the ground plane: one scale everywhere, so that sizes are metres and not pixels.

The upper edge is the far end: row 0 is the largest x of base_link, column 0 the largest y (left of the rover).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import cv2
import numpy as np
import numpy.ma  # np.median fetches it at its first call, in the midst of a frame
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.vision.camera.model import CameraModel

METRES_PER_PIXEL = 0.01
# A picture taken from straight above whose pixels are coarser than METRES_PER_PIXEL keeps them up to this size.
MAX_METRES_PER_PIXEL = 0.02
# A median over more pixels than this is taken from one in four.
MAX_MEDIAN_PIXELS = 20_000
# Beyond this range ahead a pixel of the smallest camera covers more than 1.5 cm of ground.
MAX_RANGE = 1.15


@dataclass(frozen=True, eq=False)
class GroundImage:
    """Temperatures on the ground plane.

    kelvin: (h, w) float32, finite everywhere; where `valid` is False it holds the median of the valid ones.
    valid: (h, w) bool, False outside the picture.
    metres_per_pixel: the same along both axes.
    far, left: base_link x of row 0 and y of column 0, at the pixels' centres, metres.
    eye: the lens in base_link (x, y, z), metres; None for a picture taken from straight above.
    """

    kelvin: NDArray[np.float32]
    valid: NDArray[np.bool_]
    metres_per_pixel: float = METRES_PER_PIXEL
    far: float = 0.0
    left: float = 0.0
    eye: tuple[float, float, float] | None = None
    known_median: float | None = field(default=None, repr=False)

    @cached_property
    def median(self) -> float:
        """Robust background: median of the valid temperatures, kelvin."""
        if self.known_median is not None:
            return self.known_median
        step = 2 if self.kelvin.size > MAX_MEDIAN_PIXELS else 1
        return float(np.median(self.kelvin[::step, ::step][self.valid[::step, ::step]]))

    def to_base(self, rows_columns: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (N, 2) as (row, column) to base_link (N, 2), metres."""
        corner = np.array([self.far, self.left])
        return corner - np.asarray(rows_columns, dtype=np.float64) * self.metres_per_pixel

    def to_pixel(self, points_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """base_link (N, 2) in metres to (row, column) (N, 2), not rounded."""
        return ((self.far, self.left) - np.asarray(points_base, dtype=np.float64)) / self.metres_per_pixel


class GroundRectifier:
    """Lays frames of one camera out on the ground plane; its tables are made once."""

    def __init__(self, camera: CameraModel, metres_per_pixel: float = METRES_PER_PIXEL) -> None:
        self.camera = camera
        ground = camera.ground_lookup.reshape(-1, 2)
        ground = ground[np.isfinite(ground).all(axis=1) & (ground[:, 0] <= MAX_RANGE)]
        if not len(ground):
            raise BadInput(f"camera {camera.name}: sees no ground within {MAX_RANGE} m; check the mount's pitch")
        near = float(ground[:, 0].min())
        far = float(ground[:, 0].max())
        side = float(np.abs(ground[:, 1]).max())
        rows = int((far - near) / metres_per_pixel) + 1
        columns = 2 * int(side / metres_per_pixel) + 1
        self._far, self._left = far, (columns // 2) * metres_per_pixel
        self._scale = metres_per_pixel
        x = self._far - np.arange(rows) * metres_per_pixel
        y = self._left - np.arange(columns) * metres_per_pixel
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        uv = camera.ground_to_pixel(points)
        inside = camera.inside(uv, 1.0).reshape(rows, columns)
        table = np.nan_to_num(uv, nan=-1e3).astype(np.float32).reshape(rows, columns, 2)
        self._maps = cv2.convertMaps(table[..., 0], table[..., 1], cv2.CV_16SC2)
        self.valid: NDArray[np.bool_] = inside
        self.valid.setflags(write=False)

    def rectify(self, frame: Frame) -> GroundImage:
        """The ground that a frame shows, as if it were flat. Raises BadInput for a frame of another size."""
        if frame.size != (self.camera.width, self.camera.height):
            raise BadInput(
                f"frame {frame.sequence}: {frame.size[0]}x{frame.size[1]} pixels, but camera {self.camera.name} "
                f"has {self.camera.width}x{self.camera.height}"
            )
        laid = cv2.remap(frame.kelvin(), *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        kelvin = np.asarray(laid, np.float32)
        valid = self._valid_of(frame)
        median = float(np.median(kelvin[valid]))
        kelvin[~valid] = median
        eye = (self.camera.x, self.camera.y, self.camera.z)
        return GroundImage(kelvin, valid, self._scale, self._far, self._left, eye, median)

    def _valid_of(self, frame: Frame) -> NDArray[np.bool_]:
        if frame.shown is None:
            return self.valid
        held = cv2.remap(frame.shown.astype(np.uint8), *self._maps, cv2.INTER_NEAREST)
        both: NDArray[np.bool_] = self.valid & (held > 0)
        return both if both.any() else self.valid


@lru_cache(maxsize=4)
def rectifier_of(camera: CameraModel) -> GroundRectifier:
    """The rectifier of a camera; its tables are made once."""
    return GroundRectifier(camera)


def from_picture(picture: NDArray[np.floating], metres_per_pixel: float) -> GroundImage:
    """A picture that was taken straight from above, its centre becomes the origin.

    Resampled to METRES_PER_PIXEL; where its own pixels are coarser they stay as they are up to MAX_METRES_PER_PIXEL.

    picture: (h, w), kelvin or any other scale. Raises BadInput for anything but a finite picture of one channel.
    """
    picture = np.asarray(picture, dtype=np.float32)
    if picture.ndim != 2 or not picture.size or not np.isfinite(picture).all():
        raise BadInput(f"picture of shape {picture.shape}: one channel of finite values is expected")
    if not 1e-4 < metres_per_pixel < 1.0:
        raise BadInput(f"metres_per_pixel = {metres_per_pixel:g}: a value between 0.0001 and 1 is expected")
    scale = min(max(metres_per_pixel, METRES_PER_PIXEL), MAX_METRES_PER_PIXEL)
    factor = metres_per_pixel / scale
    size = tuple(max(1, round(n * factor)) for n in picture.shape[::-1])
    resized = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if factor < 1.0 else cv2.INTER_LINEAR)
    kelvin = np.asarray(resized, np.float32)
    rows, columns = kelvin.shape
    return GroundImage(kelvin, np.ones(kelvin.shape, bool), scale, (rows - 1) / 2 * scale, (columns - 1) / 2 * scale)
