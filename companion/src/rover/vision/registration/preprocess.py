"""From 16-bit counts to the 8-bit picture that features are found in (section 3.1.1 of the paper).

Steps, each switchable: row and column fixed pattern, dead pixels, Gaussian filter, contrast stretch between two
percentiles that are held over time, histogram equalisation, CLAHE. Their order matters: offsets are removed before
anything amplifies them. Without the stretch the limits are the picture's own minimum and maximum: 8 bits must do.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

# Pixels over which the scene is taken to be smooth when stripes are told from it.
STRIPE_WINDOW_PX = 9

# A pixel this many times the mean deviation away from the median of its neighbours is dead or stuck.
DEAD_FACTOR = 12.0


@dataclass(frozen=True)
class PreprocessSettings:
    """Which steps run, and how strongly.

    percentiles: share of the picture (percent) that may clip at the dark and at the bright end.
    hold: share of the former limits kept at each frame; the stretch must not flicker with what enters the picture.
    stretch: between the percentiles; otherwise between minimum and maximum, or not at all where there are 8 bits.
    equalize: the histogram of the whole picture made flat (OpenCV's equalizeHist).
    clahe_clip: contrast limit, 0 leaves CLAHE out. clahe_tiles: tiles along each side.
    """

    fixed_pattern: bool = True
    dead_pixels: bool = True
    gaussian_sigma: float = 0.0
    percentiles: tuple[float, float] = (1.0, 99.0)
    hold: float = 0.8
    stretch: bool = True
    equalize: bool = False
    clahe_clip: float = 3.0
    clahe_tiles: int = 4


def remove_stripes(image: Image) -> Image:
    """Row and column offsets of the read-out taken off, (H, W) float32.

    An offset is the mean along its line of what differs from the neighbouring lines, clipped so that the edges of
    the scene don't count.
    """
    for kernel, axis in (((STRIPE_WINDOW_PX, 1), 0), ((1, STRIPE_WINDOW_PX), 1)):
        sharp = image - cv2.blur(image, kernel, borderType=cv2.BORDER_REFLECT_101)
        limit = 2.0 * float(cv2.mean(np.abs(sharp))[0])
        offsets = np.clip(sharp, -limit, limit).mean(axis=axis, keepdims=True)
        image = image - offsets
    return image


def repair_dead_pixels(image: Image) -> Image:
    """Isolated pixels far off the median of their 3×3 neighbourhood replaced by it, (H, W) float32."""
    median = cv2.medianBlur(image, 3)
    deviation = cv2.absdiff(image, median)
    limit = DEAD_FACTOR * float(cv2.mean(deviation)[0])
    return np.where(deviation > limit, median, image) if limit > 0.0 else image


def contrast_limits(image: Image, percentiles: tuple[float, float]) -> tuple[float, float]:
    """The values below and above which the given shares of the picture lie; every fourth pixel is asked."""
    low, high = np.percentile(image[::2, ::2], percentiles)
    return float(low), float(high)


def stretch(image: Image, limits: tuple[float, float]) -> NDArray[np.uint8]:
    """`limits` to 0 and 255, linear, clipped; a flat picture becomes black."""
    low, high = limits
    scale = 255.0 / (high - low) if high > low else 0.0
    picture: NDArray[np.uint8] = np.clip((image - low) * scale, 0.0, 255.0).astype(np.uint8)
    return picture


def local_contrast(counts: NDArray[np.uint16] | NDArray[np.uint8] | Image, sigma: float = 12.0) -> NDArray[np.uint8]:
    """Deviation of each pixel (H, W) from its surroundings, in units of their deviation: ±3 become 0 and 255.

    The same piece of ground looks the same in two pictures then, whatever else is in them: a stretch between the
    limits of the whole picture turns pale when the sky comes into view. sigma: extent of the surroundings, pixels.
    """
    image = np.asarray(counts, np.float32)
    sharp = image - _surroundings(image, sigma)
    deviation = np.sqrt(np.maximum(_surroundings(sharp * sharp, sigma), 0.0))
    floor = 0.05 * float(deviation.max()) + 1e-6  # flat surroundings hold noise alone, which is not to be amplified
    return np.clip(sharp / (deviation + floor) * (127.5 / 3.0) + 127.5, 0.0, 255.0).astype(np.uint8)


def _surroundings(image: Image, sigma: float) -> Image:
    """A Gaussian mean, worked out in a quarter of the size: nothing finer is left in it."""
    height, width = image.shape
    small = cv2.resize(image, (max(1, width // 4), max(1, height // 4)), interpolation=cv2.INTER_AREA)
    mean = cv2.GaussianBlur(small, (0, 0), sigma / 4.0, borderType=cv2.BORDER_REFLECT_101)
    return np.asarray(cv2.resize(mean, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)


@dataclass
class Preprocessor:
    """The chain with its memory: the limits of the contrast stretch."""

    settings: PreprocessSettings = field(default_factory=PreprocessSettings)
    limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        tiles = self.settings.clahe_tiles
        self._clahe = cv2.createCLAHE(self.settings.clahe_clip, (tiles, tiles))

    def clean(self, counts: NDArray[np.uint16] | NDArray[np.uint8]) -> Image:
        """Counts (H, W) to float32 without fixed pattern, dead pixels and (if asked) fine noise."""
        image = counts.astype(np.float32)
        if self.settings.fixed_pattern:
            image = remove_stripes(image)
        if self.settings.dead_pixels:
            image = repair_dead_pixels(image)
        if self.settings.gaussian_sigma > 0.0:
            return np.asarray(cv2.GaussianBlur(image, (0, 0), self.settings.gaussian_sigma), np.float32)
        return image

    def to_8_bit(self, image: Image) -> NDArray[np.uint8]:
        """Stretch with held limits, equalisation, CLAHE; (H, W) uint8."""
        low, high = self._limits_of(image)
        if self.settings.stretch and self.limits is not None:
            keep = self.settings.hold
            low = keep * self.limits[0] + (1.0 - keep) * low
            high = keep * self.limits[1] + (1.0 - keep) * high
        self.limits = (low, high)
        picture = stretch(image, self.limits)
        if self.settings.equalize:
            picture = np.asarray(cv2.equalizeHist(picture), np.uint8)
        return np.asarray(self._clahe.apply(picture), np.uint8) if self.settings.clahe_clip > 0.0 else picture

    def _limits_of(self, image: Image) -> tuple[float, float]:
        if self.settings.stretch:
            return contrast_limits(image, self.settings.percentiles)
        low, high = float(image.min()), float(image.max())
        return (0.0, 255.0) if low >= 0.0 and high <= 255.0 else (low, high)

    def __call__(self, counts: NDArray[np.uint16] | NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The whole chain: counts (H, W) to the picture (H, W) uint8 that features are found in."""
        return self.to_8_bit(self.clean(counts))

    def forget(self) -> None:
        """Drops the held limits: after a shutter event or a jump the old ones mean nothing."""
        self.limits = None
