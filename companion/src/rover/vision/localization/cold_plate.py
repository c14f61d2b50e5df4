"""Marker plates in a thermal picture: a strip of bare aluminium reflects the sky, so it is far colder than any ground.

By day and by night: clear sky radiates like something 15 to 40 K colder than the air. A low overcast does not, and then
no plate is found. What is found is told by cold and size alone; which plate it may be is told by where it lies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.vision.camera.model import CameraModel

Mask = NDArray[np.bool_]

# Colder than the picture's median by this much, kelvin: by night nothing else comes within 5 K of that. By day leaves
# and what lies in the shade keep to the air's temperature, and sunlit ground gets away from them: up to this much more.
COLDER_K = 11.0
BY_SUN_K = 8.0
# A whole plate covers this share of its size, least and most, by what lies under the middle of its edge.
WHOLE = (0.55, 1.6)
# Farther ahead than this, metres, a pixel covers centimetres.
MAX_RANGE_M = 1.15
# What blurs over a plate's edge, pixels, and the ring behind it that tells what the ground around is like.
RIM_PX, RING_PX = 2, 4
# A plate's middle errs by so much, metres and share of its distance, 1σ.
ERROR_M, ERROR_SHARE = 0.004, 0.008


@dataclass(frozen=True, eq=False)
class ColdSpot:
    """Something as cold as a plate. x, y: its middle in base_link, metres; whole: all of a plate, in full view.

    sigma: 1σ of the middle, metres. mask: the pixels (H, W) that show it, with the blur of its edge.
    """

    x: float
    y: float
    sigma: float
    whole: bool
    mask: Mask


def colder(hour: float) -> float:
    """How much colder than the ground a plate is at least, kelvin, at an hour of the day."""
    return COLDER_K + BY_SUN_K * max(0.0, math.sin(math.pi * (hour - 6.0) / 12.0))


def cold_spots(frame: Frame, camera: CameraModel, side: float, colder_k: float) -> list[ColdSpot]:
    """What may be a plate of `side` metres in a frame, from the top of the picture down; colder_k as from `colder`."""
    ground, cell = _ground(camera)
    kelvin = frame.kelvin()
    shown = cell > 0.0
    if not shown.any():
        return []
    middle = float(np.median(kelvin[shown]))
    cold = (kelvin < middle - colder_k) & shown
    if not cold.any():
        return []
    count, labels, stats, _ = cv2.connectedComponentsWithStats(cold.astype(np.uint8), connectivity=8)
    found = []
    for label in range(1, count):
        part = labels == label
        # Half of the way down from the ground to the plate: there its edge is, whatever the blur.
        half = 0.5 * (middle + float(np.median(kelvin[part])))
        grown = cv2.dilate(part.astype(np.uint8), np.ones((2 * RIM_PX + 1,) * 2, np.uint8)).astype(bool)
        body = grown & shown & (kelvin < half)
        weight = cell[body]
        area = float(weight.sum())
        if area < 0.05 * side * side:  # a pixel or two
            continue
        x, y = (weight[:, None] * ground[body]).sum(axis=0) / area
        left, top, width, height = stats[label, :4].tolist()
        at_edge = left <= 1 or top <= 1 or left + width >= camera.width - 1 or top + height >= camera.height - 1
        ranged = bool((ground[body][:, 0] <= MAX_RANGE_M).all())
        whole = not at_edge and ranged and WHOLE[0] <= area / side**2 <= WHOLE[1]
        found.append(ColdSpot(float(x), float(y), ERROR_M + ERROR_SHARE * float(np.hypot(x, y)), whole, grown))
    return found


def without(frame: Frame, spots: list[ColdSpot]) -> Frame:
    """The same picture with plain ground, as warm as that around, where the spots are."""
    if not spots:
        return frame
    counts = frame.counts.copy()
    away = np.any([spot.mask for spot in spots], axis=0)
    for spot in spots:
        ring = cv2.dilate(spot.mask.astype(np.uint8), np.ones((2 * RING_PX + 1,) * 2, np.uint8)).astype(bool) & ~away
        if ring.any():
            counts[spot.mask] = np.uint16(np.median(frame.counts[ring]))
    return replace(frame, counts=counts)


@lru_cache(maxsize=4)
def _ground(camera: CameraModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What each pixel shows: the point (H, W, 2) of base_link, and how many m² (H, W), 0 where it shows no ground."""
    ground = camera.ground_lookup.astype(np.float64)
    down, right = np.gradient(ground, axis=0), np.gradient(ground, axis=1)
    cell = np.abs(down[..., 0] * right[..., 1] - down[..., 1] * right[..., 0])
    shown = np.isfinite(cell) & np.isfinite(ground).all(axis=2) & (ground[..., 0] <= 2.0 * MAX_RANGE_M)
    return np.where(shown[..., None], ground, 0.0), np.where(shown, cell, 0.0)
