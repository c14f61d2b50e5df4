"""Colours of the plots, BGR as OpenCV wants them, and temperatures as false colours."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]

PAPER: Colour = (250, 250, 249)
INK: Colour = (48, 40, 34)
FAINT: Colour = (112, 104, 97)
UNSEEN: Colour = (226, 224, 222)
UNMEASURED: Colour = (240, 239, 238)
HATCH: Colour = (190, 187, 184)
WHITE: Colour = (255, 255, 255)
ZONE: Colour = (52, 38, 214)
GOAL: Colour = (66, 148, 26)
OBSTACLE: Colour = (88, 74, 64)
PATH: Colour = (255, 255, 255)
LAUNCH: Colour = (196, 112, 22)

# Perceptually uniform and the same to every kind of colour vision; leaves red and green to the marks.
COLORMAP = cv2.COLORMAP_CIVIDIS


def temperature_span(kelvin: NDArray[np.float32]) -> tuple[float, float]:
    """Temperatures between which the colours run: percentiles 1 and 99, at least 1 K apart; nan is left out."""
    known = kelvin[np.isfinite(kelvin)]
    if known.size == 0:
        return 293.0, 294.0
    low, high = (float(value) for value in np.percentile(known, (1.0, 99.0)))
    if high - low < 1.0:
        middle = 0.5 * (low + high)
        low, high = middle - 0.5, middle + 0.5
    return low, high


def false_colour(kelvin: NDArray[np.float32], span: tuple[float, float]) -> NDArray[np.uint8]:
    """Temperatures (h, w) as BGR (h, w, 3); nan becomes the colour of unseen ground."""
    low, high = span
    known = np.isfinite(kelvin)
    scaled = np.clip((np.where(known, kelvin, low) - low) / (high - low), 0.0, 1.0)
    picture = cv2.applyColorMap(np.round(scaled * 255.0).astype(np.uint8), COLORMAP)
    picture[~known] = UNSEEN
    return np.asarray(picture, dtype=np.uint8)
