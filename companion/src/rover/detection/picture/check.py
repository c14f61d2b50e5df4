"""Is there anything in a picture to look at? Each fault has its own name, so that a person knows what to mend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

# A picture with this share of its pixels at the end of its range shows nothing there.
SATURATED_SHARE = 0.5
# The middle 98 % of a picture span less than this: 8-bit grey levels, or hundredths of a kelvin in 16 bits.
BLANK_SPAN = {1: 2, 2: 4}
MIN_SIDE_PX = 32


def check_picture(
    picture: NDArray[np.uint8] | NDArray[np.uint16],
    where: str,
    size: tuple[int, int] | None = None,
    radiometric: bool = False,
) -> None:
    """Raises BadInput (one line: where, the fault's name, what to do) for a picture that tells nothing.

    size: (width, height) that it must have. radiometric: 16 bits of kelvin x 100 were promised.
    """
    height, width = picture.shape
    if size is not None and (width, height) != size:
        raise BadInput(f"{where}: wrong size: {width}x{height} pixels, {size[0]}x{size[1]} expected")
    if min(width, height) < MIN_SIDE_PX:
        raise BadInput(f"{where}: wrong size: {width}x{height} pixels, at least {MIN_SIDE_PX} either way are expected")
    if radiometric and picture.dtype == np.uint8:
        raise BadInput(f"{where}: 8-bit picture where 16 bits (kelvin × 100) were promised; store the camera's counts")
    if picture.dtype == np.uint16 and int(picture.max()) <= 255:
        raise BadInput(f"{where}: 8-bit values in a 16-bit file (none above 255); store the camera's counts")
    low, high = np.percentile(picture[::2, ::2], (1, 99))
    end = np.iinfo(picture.dtype).max
    if float((picture == end).mean()) >= SATURATED_SHARE:
        raise BadInput(f"{where}: saturated: {(picture == end).mean():.0%} of its pixels are {end}; lower the gain")
    if high - low < BLANK_SPAN[picture.dtype.itemsize]:
        raise BadInput(f"{where}: blank: its pixels span only {high - low:g} levels; is the lens covered?")
