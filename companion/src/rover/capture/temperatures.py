"""What numbers in a picture mean as temperatures, and temperatures as 16-bit counts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import KELVIN_PER_COUNT
from rover.capture.radiometry import ZERO_CELSIUS
from rover.errors import BadInput

# From the coldest sky to the hottest range of any camera of this kind; the median of a picture lies in between.
PLAUSIBLE_KELVIN = (123.0, 2500.0)
# Where a picture's median must lie whose file does not say what its numbers mean. In °C the same outdoor temperatures
# are -70 to 150: no number can be taken for both.
OUTDOORS_KELVIN = (203.0, 423.0)


def as_centikelvin(kelvin: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Temperatures (H, W) as kelvin × 100, 0 where there is none (NaN)."""
    counts = np.nan_to_num(np.rint(kelvin / KELVIN_PER_COUNT), nan=0.0)
    centikelvin: NDArray[np.uint16] = np.clip(counts, 0, 65535).astype(np.uint16)
    return centikelvin


def kelvin_of_counts(counts: NDArray[np.uint16], name: str) -> NDArray[np.float32]:
    """Counts of kelvin × 100. Raises BadInput where their median is no temperature outdoors."""
    kelvin: NDArray[np.float32] = counts.astype(np.float32) * np.float32(KELVIN_PER_COUNT)
    check_median(kelvin, OUTDOORS_KELVIN, f"{name}: 16-bit counts that are not kelvin × 100")
    return kelvin


def kelvin_of_floats(values: NDArray[Any], name: str) -> NDArray[np.float32]:
    """Floating-point pixels (H, W) in kelvin or °C, as the file's median says; NaN and infinities stay NaN."""
    known = values[np.isfinite(values)]
    median = float(np.median(known)) if known.size else float("nan")
    low, high = OUTDOORS_KELVIN
    if low <= median <= high:
        offset = 0.0
    elif low <= median + ZERO_CELSIUS <= high:
        offset = ZERO_CELSIUS
    else:
        raise BadInput(f"{name}: floating-point pixels with a median of {median:g}: neither kelvin nor °C")
    return np.where(np.isfinite(values), values + offset, np.nan).astype(np.float32)


def check_median(kelvin: NDArray[np.float32], limits: tuple[float, float], complaint: str) -> None:
    """Raises BadInput with the complaint where the median lies outside of the limits."""
    known = kelvin[np.isfinite(kelvin)]
    median = float(np.median(known)) if known.size > kelvin.size // 2 else float("nan")
    if not limits[0] <= median <= limits[1]:
        shown = f"a median of {median:.0f} K" if np.isfinite(median) else "most pixels without a temperature"
        raise BadInput(f"{complaint}: {shown}")
