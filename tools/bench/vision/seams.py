"""Does a mosaic show where its pictures end? Steps across the edges of the pictures in it, beside their own content.

A step is the difference between the means of two lines, 3 px on this and on that side of an edge, over 64 px of it.
What the pictures show steps, too: the same is measured on lines inside the pictures, where no seam is.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.vision.mosaic.picture_graph import Placement
from rover.vision.mosaic.stitch import canvas, stitch
from rover.vision.registration.homography import apply_homography

from tools.bench.vision.truth import Picture, Points

BESIDE, LENGTH, INSIDE = 3.0, 64, 40.0


def seam_table(pictures: Sequence[Picture], placement: Placement) -> str:
    """Median and 75th percentile of the steps, counts: stitched, laid on top of each other, and without a seam."""
    mosaic, shift = stitch(pictures, placement)
    pasted = _pasted(pictures, placement)
    whole = mosaic.astype(np.float32)
    lines = ["| steps in temperature, counts | median | 75 % |", "|---|---|---|"]
    for name, picture, inside in (
        ("across the pictures' edges: rover stitch", whole, 0.0),
        ("across the pictures' edges: laid on top of each other", pasted, 0.0),
        (f"{INSIDE:g} px inside, where no edge is: rover stitch", whole, INSIDE),
    ):
        steps = np.concatenate([
            _steps(picture, shift @ homography, pictures[number].shape, inside)
            for number, homography in sorted(placement.homographies.items())
        ])  # fmt: skip
        lines.append(f"| {name} | {np.median(steps):.1f} | {np.percentile(steps, 75):.1f} |")
    return "\n".join(lines)


def _pasted(pictures: Sequence[Picture], placement: Placement) -> NDArray[np.float32]:
    shift, size = canvas(placement, pictures)
    whole = np.zeros(size[::-1], np.float32)
    for number, homography in sorted(placement.homographies.items()):
        laid = cv2.warpPerspective(pictures[number].astype(np.float32), shift @ homography, size)
        full = cv2.warpPerspective(np.ones(pictures[number].shape, np.float32), shift @ homography, size) > 0.999
        whole[full] = laid[full]
    return whole


def _steps(whole: NDArray[np.float32], homography: Points, shape: tuple[int, ...], inside: float) -> Points:
    """One step for every stretch of the four sides, moved inwards by `inside`, that has pictures on both sides."""
    height, width = shape[:2]
    steps: list[float] = []
    for side in range(4):
        along = np.arange(float(LENGTH), (width if side % 2 == 0 else height) - LENGTH)
        near, far = (
            _sampled(whole, apply_homography(homography, _line(side, along, inside + off, width, height)))
            for off in (BESIDE, -BESIDE)
        )
        for start in range(0, len(along) - LENGTH + 1, LENGTH):
            a, b = near[start : start + LENGTH], far[start : start + LENGTH]
            if a.min() > 0.0 and b.min() > 0.0:
                steps.append(abs(float(a.mean() - b.mean())))
    return np.array(steps)


def _line(side: int, along: Points, inwards: float, width: int, height: int) -> Points:
    """Pixels (N, 2) of a line `inwards` from one of the picture's sides."""
    across = np.full_like(along, (inwards, width - 1.0 - inwards, height - 1.0 - inwards, inwards)[side])
    return np.column_stack((along, across) if side % 2 == 0 else (across, along))


def _sampled(whole: NDArray[np.float32], points: Points) -> NDArray[np.float32]:
    at = points.astype(np.float32)
    values = cv2.remap(whole, at[:, :1], at[:, 1:], cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(values[:, 0], np.float32)
