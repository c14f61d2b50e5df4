"""A second look at ground about to be driven: what the sum of all frames says of a place, beside the network per look.

A matched filter over the mosaic. Above a mine 1 to 5 cm deep the contrast falls to half at 5 to 6 cm from the middle;
soil is uneven at every scale. The mean within a Gaussian as wide as that profile, less the mean of a ring around it, is
close to the filter that separates the two best (`tools/evaluate/limit.py` has the best one's d'). It finds places where
a mine may lie, many more than there are mines: enough to keep wheels off them, not to report them.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# Standard deviations of both Gaussians, metres.
MINE_WIDTH, AROUND_WIDTH = 0.05, 0.12
# What stands out by more than this, kelvin, is nobody's weak spot: the network sees it, and it must not drown the rest.
CLIP_K = 2.0
# Of each Gaussian this share must lie on ground that is known.
LEAST_KNOWN = 0.6
# What the ground answers at least, kelvin: the camera's noise after many frames.
LEAST_SPREAD_K = 0.03
# Peaks nearer to each other than this are one, metres.
SPACING = 0.08
# Hours of the day between which mines down to 5 cm are warmer than soil that is not dry sand, and colder: away from the
# zero crossings of docs/results/ground.md. Between them they may be either.
WARM_HOURS = (9.0, 16.0)
COLD_HOURS = (19.0, 6.5)


def sign_at(hour: float) -> int:
    """1 where buried mines are warmer than soil at this hour (0 to 24), -1 where they are colder, 0 for either."""
    if WARM_HOURS[0] <= hour <= WARM_HOURS[1]:
        return 1
    return -1 if hour >= COLD_HOURS[0] or hour <= COLD_HOURS[1] else 0


def contrast(kelvin: NDArray[np.float32], resolution: float) -> NDArray[np.float32]:
    """Mean within a mine's width less that of the ring around, kelvin (rows, columns); nan where too little is known.

    kelvin: mosaic (rows, columns), nan where nothing is known; `resolution` in metres.
    """
    known = np.isfinite(kelvin)
    if not known.any():
        return np.full(kelvin.shape, np.nan, np.float32)
    middle = np.float32(np.median(kelvin[known]))
    plain = np.where(known, np.clip(kelvin - middle, -CLIP_K, CLIP_K), 0.0).astype(np.float32)
    mask = known.astype(np.float32)
    (near, near_share), (around, around_share) = (
        (_blur(plain, width / resolution), _blur(mask, width / resolution)) for width in (MINE_WIDTH, AROUND_WIDTH)
    )
    fair = known & (near_share >= LEAST_KNOWN) & (around_share >= LEAST_KNOWN)
    answer = near / np.maximum(near_share, LEAST_KNOWN) - around / np.maximum(around_share, LEAST_KNOWN)
    return np.where(fair, answer, np.nan).astype(np.float32)


def likeness(kelvin: NDArray[np.float32], resolution: float, sign: int = 0) -> NDArray[np.float32]:
    """How far each cell stands out as a buried mine would, in robust standard deviations of this ground's answers.

    Arguments as of `contrast`. `sign`: of the contrast that is looked for, 0 for either. Zero where too little around
    is known.
    """
    answer = contrast(kelvin, resolution)
    fair = np.isfinite(answer)
    if not fair.any():
        return np.zeros(kelvin.shape, np.float32)
    spread = max(1.4826 * float(np.median(np.abs(answer[fair]))), LEAST_SPREAD_K)
    signed = np.abs(answer) if sign == 0 else sign * answer
    return np.where(fair, signed / np.float32(spread), 0.0).astype(np.float32)


def peaks(like: NDArray[np.float32], resolution: float, least: float) -> NDArray[np.float64]:
    """Places (N, 3): x, y in metres from the raster's corner and likeness, of local maxima of at least `least`."""
    reach = 2 * max(1, round(SPACING / resolution)) + 1
    highest = (like >= cv2.dilate(like, np.ones((reach, reach), np.uint8))) & (like >= least)
    rows, columns = np.nonzero(highest)
    return np.column_stack(((columns + 0.5) * resolution, (rows + 0.5) * resolution, like[rows, columns]))


def _blur(picture: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT), np.float32)
