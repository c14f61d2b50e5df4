"""Registers two pictures and lays the first over the second, in false colours where they differ.

python docs/examples/register_pictures.py docs/examples/frames/00.png docs/examples/frames/03.png overlay.png
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import read_picture
from rover.vision.registration.register import register


def grey(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """Any picture in 8 bits; its coldest and warmest hundredth are cut off."""
    low, high = np.percentile(picture, (1, 99))
    stretched: NDArray[np.float64] = np.clip((picture - low) / max(high - low, 1), 0, 1)
    return (255 * stretched).astype(np.uint8)


def overlay(a: Path, b: Path) -> tuple[NDArray[np.uint8], float]:
    """(rows, columns, 3) in the pixels of b: b is green, a is red and blue. And equation 6 of the paper, in pixels.

    Raises ValueError with the reason when the pictures do not fit.
    """
    first, second = read_picture(a), read_picture(b)
    found = register(first, second)
    if found.homography is None or found.rmse_after is None:
        raise ValueError(f"{a} does not fit {b}: {found.reason}")
    rows, columns = second.shape[:2]
    moved = cv2.warpPerspective(grey(first), found.homography, (columns, rows))
    return np.dstack([moved, grey(second), moved]).astype(np.uint8), found.rmse_after


if __name__ == "__main__":
    drawn, rmse = overlay(Path(sys.argv[1]), Path(sys.argv[2]))
    if not cv2.imwrite(sys.argv[3], drawn):
        sys.exit(f"{sys.argv[3]}: cannot be written")
    print(f"{sys.argv[3]}: the pictures agree to {rmse:.2f} px")
