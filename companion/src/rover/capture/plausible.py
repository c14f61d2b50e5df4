"""Whether a picture can be temperatures of ground, and what it looks like if it cannot.

A camera with the wrong settings delivers 16 bits all the same: raw counts, the grey levels of its gain control (AGC),
the other order of bytes, another unit. Each differs from a picture in kelvin in where its values lie and how they
scatter.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import KELVIN_PER_COUNT, Frame
from rover.capture.radiometry import ZERO_CELSIUS

# The hundredth part of a picture may be colder or warmer: sky, a fire, dead pixels.
PERCENTILES = (1.0, 99.0)
MIN_GROUND_K = 223.0
MAX_GROUND_K = 373.0
# Most between cold and warm ground in one picture: wet shade beside dark stones in the sun differs by 60 K.
MAX_SPAN_K = 100.0
# Most by which the middle of the picture may change from one to the next; from shade to sun it is a few kelvin.
MAX_JUMP_K = 15.0

# With its bytes the right way round a picture is smoother by far: neighbours differ by noise, not by 256 times that.
MIN_SMOOTHER = 4.0
# Share of equal neighbours above which a step is as coarse as the noise: tenths of a kelvin; raw counts are finer.
MIN_EQUAL_SHARE = 0.12

# Pixels that are looked at, in whole rows: enough for percentiles, and soon done.
MAX_PIXELS = 20_000

MAX_8_BITS = 255
MAX_14_BITS = 16383


def doubt(counts: NDArray[np.uint16], kelvin_per_count: float | None) -> str | None:
    """Why `counts` (H, W) cannot be temperatures of ground; None when they can."""
    counts = counts[:: max(1, counts.size // MAX_PIXELS)]
    largest = int(counts.max())
    if largest > MAX_8_BITS and counts.min() != largest and not (counts & MAX_8_BITS).any():
        return "grey levels of 8 bits in the upper byte, no temperatures: switch AGC off"
    if MIN_SMOOTHER * _roughness(counts.byteswap()) < _roughness(counts):
        return "the two bytes of each pixel are swapped"
    if largest <= MAX_8_BITS:
        return "grey levels of 8 bits, no temperatures: switch AGC off"
    if kelvin_per_count is not None and _is_ground(counts, kelvin_per_count):
        return None
    if kelvin_per_count not in (None, KELVIN_PER_COUNT) and _is_ground(counts, KELVIN_PER_COUNT):
        return "kelvin × 100: the source's unit is centikelvin"
    tenths = kelvin_per_count is not None and _is_ground(counts, 0.1)
    if tenths and _equal_share(counts) >= MIN_EQUAL_SHARE:
        return "tenths of a kelvin: the source's unit is decikelvin, or switch the camera to 0.01 K"
    if largest <= MAX_14_BITS:
        other = ", or tenths of a kelvin" if tenths else ""
        return f"raw counts of 14 bits{other}, no temperatures: switch TLinear on"
    if kelvin_per_count is None:
        return "raw counts, no temperatures: switch TLinear on"
    low, high = _bounds(counts, kelvin_per_count)
    if high - low > MAX_SPAN_K:
        return "grey levels spread over 16 bits, no temperatures: switch AGC off"
    return f"{low - ZERO_CELSIUS:.0f} to {high - ZERO_CELSIUS:.0f} °C are no temperatures of ground"


def jump(before: Frame, after: Frame) -> str | None:
    """Why `after` cannot show the ground that `before` has shown, a moment earlier; None when it can."""
    if before.kelvin_per_count is None or after.kelvin_per_count is None:
        return None
    was = float(np.median(before.counts)) * before.kelvin_per_count
    change = float(np.median(after.counts)) * after.kelvin_per_count - was
    if abs(change) <= MAX_JUMP_K:
        return None
    return f"temperatures change by {change:+.0f} K from one picture to the next"


def doubts(frames: list[Frame]) -> str | None:
    """The first doubt about successive pictures, but for those behind the shutter; None when there is none."""
    shown = [frame for frame in frames if not frame.ffc]
    for frame in shown:
        found = frame.doubt or doubt(frame.counts, frame.kelvin_per_count)
        if found is not None:
            return found
    return next((found for pair in pairwise(shown) if (found := jump(*pair)) is not None), None)


def _bounds(counts: NDArray[np.uint16], kelvin_per_count: float) -> tuple[float, float]:
    low, high = np.percentile(counts, PERCENTILES) * kelvin_per_count
    return float(low), float(high)


def _is_ground(counts: NDArray[np.uint16], kelvin_per_count: float) -> bool:
    low, high = _bounds(counts, kelvin_per_count)
    return low >= MIN_GROUND_K and high <= MAX_GROUND_K and high - low <= MAX_SPAN_K


def _roughness(counts: NDArray[np.uint16]) -> float:
    """Mean difference of neighbours in a row."""
    return float(np.abs(np.diff(counts.astype(np.int32), axis=1)).mean())


def _equal_share(counts: NDArray[np.uint16]) -> float:
    return float((counts[:, 1:] == counts[:, :-1]).mean())
