"""Which ground can be brought into view from where the rover can stand: it turns, so any bearing will do.

Rasters are (rows, columns), cells of `resolution` metres.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

# Ground nearer to base_link than this is under the rover or before the picture's lower edge, metres.
NEAREST = 0.25
BEARINGS = 24
RINGS = 5


def visible_from(standing: Mask, occluders: Mask, reach: float, resolution: float) -> Mask:
    """Cells up to `reach` metres from a cell of `standing`, with no occluder on the line between.

    Bearings and distances are sampled; neighbouring cells of `standing` fill what lies between the samples.
    """
    found: Mask = standing.copy()
    for bearing in 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS:
        step = np.array([math.sin(bearing), math.cos(bearing)]) / resolution
        hidden, back = np.zeros_like(occluders), 2.0 * resolution
        for ring in np.linspace(NEAREST, reach, RINGS):
            while back < ring:
                hidden |= _shifted(occluders, step * back)
                back += 2.0 * resolution
            found |= _shifted(standing, step * float(ring)) & ~hidden
    return found


def _shifted(mask: Mask, by: NDArray[np.float64]) -> Mask:
    """The mask moved by whole (rows, columns); what comes in from outside is False."""
    rows, columns = (round(float(value)) for value in by)
    height, width = mask.shape
    out = np.zeros_like(mask)
    if abs(rows) < height and abs(columns) < width:
        out[max(rows, 0) : height + min(rows, 0), max(columns, 0) : width + min(columns, 0)] = mask[
            max(-rows, 0) : height + min(-rows, 0), max(-columns, 0) : width + min(-columns, 0)
        ]
    return out
