"""Placed pictures laid into one: each temperature the weighted mean of all that show it, 16 bits kept.

Cameras drift by tenths of a kelvin between shutter events. Each picture's offset is found from what it shares with the
others, all at once, so that a seam is no step in temperature; weights fall to nothing at a picture's edge.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.vision.mosaic.picture_graph import Placement
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.register import Picture

Points = NDArray[np.float64]
MAX_PIXELS = 200_000_000
MAX_MAGNIFICATION = 16.0


def canvas(placement: Placement, pictures: Sequence[Picture]) -> tuple[Points, tuple[int, int]]:
    """The shift (3, 3) from the reference's pixels to the mosaic's, and the mosaic's (width, height).

    Raises BadInput where perspective would make the mosaic too large to be of use.
    """
    placed = placement.homographies.items()
    corners = np.concatenate([apply_homography(homography, _corners(pictures[n])) for n, homography in placed])
    low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
    width, height = (high - low).astype(int)
    largest = max(pictures[number].size for number in placement.homographies)
    if width * height > min(MAX_PIXELS, MAX_MAGNIFICATION * largest * len(placement.homographies)):
        raise BadInput(f"a mosaic of {width}×{height} pixels: these pictures do not show one plane")
    return np.array([[1.0, 0.0, -low[0]], [0.0, 1.0, -low[1]], [0.0, 0.0, 1.0]]), (int(width), int(height))


def stitch(pictures: Sequence[Picture], placement: Placement) -> tuple[Picture, Points]:
    """The mosaic (H, W) in the depth of the pictures, 0 where none shows anything; and `canvas`'s shift (3, 3).

    Raises BadInput as `canvas` does.
    """
    shift, size = canvas(placement, pictures)
    numbers = sorted(placement.homographies)
    offsets = _offsets(pictures, placement, numbers)
    total = np.zeros(size[::-1], np.float32)
    weights = np.zeros(size[::-1], np.float32)
    for number in numbers:
        picture = pictures[number]
        homography = shift @ placement.homographies[number]
        box, local = _box(homography, picture, size)
        weight = cv2.warpPerspective(_feather(picture.shape), local, box[2:], flags=cv2.INTER_LINEAR)
        values = cv2.warpPerspective(
            picture.astype(np.float32), local, box[2:], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        place = np.s_[box[1] : box[1] + box[3], box[0] : box[0] + box[2]]
        total[place] += weight * (values - np.float32(offsets[number]))
        weights[place] += weight
    shown = weights > 1e-6
    top = np.iinfo(pictures[numbers[0]].dtype).max
    mean = np.divide(total, weights, out=np.zeros_like(total), where=shown)
    rounded = np.where(shown, np.clip(np.rint(mean), 0, top), 0)
    if pictures[numbers[0]].dtype == np.uint8:
        return rounded.astype(np.uint8), shift
    return rounded.astype(np.uint16), shift


def _corners(picture: Picture) -> Points:
    height, width = picture.shape
    return np.array([[0.0, 0.0], [width - 1.0, 0.0], [width - 1.0, height - 1.0], [0.0, height - 1.0]])


def _box(homography: Points, picture: Picture, size: tuple[int, int]) -> tuple[tuple[int, int, int, int], Points]:
    """The part (x, y, width, height) of the mosaic that a picture covers, and the homography into that part."""
    corners = apply_homography(homography, _corners(picture))
    low = np.clip(np.floor(corners.min(axis=0)), 0, None).astype(int)
    high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, size)
    shift = np.array([[1.0, 0.0, -low[0]], [0.0, 1.0, -low[1]], [0.0, 0.0, 1.0]])
    return (int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])), shift @ homography


def _feather(shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Weight of each pixel (H, W): how far it is from the picture's edge."""
    height, width = shape[:2]
    across = np.minimum(np.arange(width) + 1, width - np.arange(width)) / width
    down = np.minimum(np.arange(height) + 1, height - np.arange(height)) / height
    return np.minimum.outer(down, across).astype(np.float32)


def _offsets(pictures: Sequence[Picture], placement: Placement, numbers: list[int]) -> dict[int, float]:
    """By how much each picture reads more than the common level, from the medians of what pairs of them share."""
    rows, differences = [], []
    for index, a in enumerate(numbers):
        grid = _grid(pictures[a])
        values = pictures[a][grid[:, 1].astype(int), grid[:, 0].astype(int)].astype(np.float64)
        for other in range(index + 1, len(numbers)):
            b = numbers[other]
            matrix = np.linalg.inv(placement.homographies[b]) @ placement.homographies[a]
            there = np.rint(apply_homography(matrix, grid))
            inside = ((there >= 0) & (there < pictures[b].shape[::-1])).all(axis=1)
            if inside.sum() < 30:
                continue
            column, row = there[inside].astype(int).T
            difference = values[inside] - pictures[b][row, column]
            equation = np.zeros(len(numbers))
            equation[index], equation[other] = 1.0, -1.0
            weight = np.sqrt(inside.sum())
            rows.append(equation * weight)
            differences.append(float(np.median(difference)) * weight)
    if not rows:
        return dict.fromkeys(numbers, 0.0)
    rows.append(np.ones(len(numbers)))  # the mean of all offsets is nothing: only differences are known
    differences.append(0.0)
    solution = np.linalg.lstsq(np.stack(rows), np.array(differences), rcond=None)[0]
    return dict(zip(numbers, map(float, solution), strict=True))


def _grid(picture: Picture) -> Points:
    height, width = picture.shape
    x, y = np.meshgrid(np.linspace(2, width - 3, 40).round(), np.linspace(2, height - 3, 32).round())
    return np.column_stack((x.ravel(), y.ravel()))
