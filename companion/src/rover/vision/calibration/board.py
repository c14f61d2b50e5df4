"""Boards and boxes of known size, and where their points lie in a thermal or visible picture.

A thermal board is hot where it is painted, or cold where it is cut out, and blurred either way: both polarities are
tried on a stretched, enlarged picture. Points are pixels with (0, 0) in the centre of the upper left one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.vision.calibration.saddle import refine_saddles

Points = NDArray[np.float64]

STRETCH_PERCENTILES = (0.5, 99.5)
# Detectors were made for pictures of this size: smaller ones are enlarged.
WORKING_WIDTH_PX = 640

# Half window of the corner's refinement, as a share of the distance between corners: it must not reach the next.
SUBPIX_SHARE = 0.35

# Blur before it, in the same measure: a saddle stays where it is, noise goes.
SMOOTH_SHARE = 0.12


@dataclass(frozen=True)
class Board:
    """columns × rows of points, `square` metres apart: inner corners of a checkerboard, or centres of circles.

    staggered: every second row of circles stands between those of the others (OpenCV's asymmetric grid); `square` is
    the distance between rows, and half of that between the circles of a row.
    """

    columns: int
    rows: int
    square: float
    circles: bool = False
    staggered: bool = False

    def __post_init__(self) -> None:
        if not (3 <= self.columns <= 50 and 3 <= self.rows <= 50):
            raise BadInput(f"board {self.columns}x{self.rows}: 3 to 50 inner corners (or circles) a side are expected")
        if not 1e-4 <= self.square <= 10.0:
            raise BadInput(f"board: square {self.square:g} m: the distance between points in metres is expected")

    @property
    def points(self) -> Points:
        """(N, 3) in metres on the board's plane, row by row."""
        grid = np.mgrid[0 : self.columns, 0 : self.rows].T.reshape(-1, 2) * self.square
        if self.staggered:
            across, down = grid.T
            grid = np.column_stack((2.0 * across + (np.rint(down / self.square) % 2) * self.square, down))
        return np.column_stack((grid, np.zeros(len(grid))))


def stretched(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """A picture (H, W) of 8 or 16 bits as 8 bits of full contrast; hot pixels and dead ones don't set the limits."""
    low, high = np.percentile(picture, STRETCH_PERCENTILES)
    scale = 255.0 / max(float(high - low), 1.0)
    grey: NDArray[np.uint8] = np.clip((picture.astype(np.float32) - low) * scale, 0.0, 255.0).astype(np.uint8)
    return grey


def find_board(picture: NDArray[Any], board: Board) -> Points | None:
    """The board's points (N, 2) in a picture (H, W) of 8 or 16 bits, in the order of `board.points`; None without."""
    grey = stretched(picture)
    factor = max(1, -(-WORKING_WIDTH_PX // grey.shape[1]))
    large = cv2.resize(grey, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC) if factor > 1 else grey
    for polarity in (large, cv2.bitwise_not(large)):
        look = _circles if board.circles else _corners
        found = look(np.asarray(polarity, np.uint8), board)
        if found is not None:
            points = (found + 0.5) / factor - 0.5
            return points if board.circles else refine_saddles(grey, points, board.columns)
    return None


def _corners(grey: NDArray[np.uint8], board: Board) -> Points | None:
    size = (board.columns, board.rows)
    good, corners = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not good:
        flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
        good, corners = cv2.findChessboardCorners(cv2.GaussianBlur(grey, (0, 0), 1.5), size, flags=flags)
    if not good or corners is None or len(corners) != board.columns * board.rows:
        return None
    spacing = _spacing(corners.reshape(-1, 2).astype(np.float64), board)
    half = int(max(2, SUBPIX_SHARE * spacing))
    smooth = cv2.GaussianBlur(grey, (0, 0), SMOOTH_SHARE * spacing)
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    refined = cv2.cornerSubPix(smooth, corners.astype(np.float32), (half, half), (-1, -1), criteria)
    return refined.reshape(-1, 2).astype(np.float64)


def _circles(grey: NDArray[np.uint8], board: Board) -> Points | None:
    settings = cv2.SimpleBlobDetector.Params()
    settings.minArea = 12.0
    settings.maxArea = grey.size / (board.columns * board.rows)
    settings.minDistBetweenBlobs = 4.0
    settings.filterByColor = True
    settings.blobColor = 0
    settings.filterByConvexity = True
    settings.minConvexity = 0.85
    detector = cv2.SimpleBlobDetector.create(settings)
    smooth = cv2.GaussianBlur(grey, (0, 0), 1.5)
    size = (board.columns, board.rows)
    layout = cv2.CALIB_CB_ASYMMETRIC_GRID if board.staggered else cv2.CALIB_CB_SYMMETRIC_GRID
    good, centres = cv2.findCirclesGrid(smooth, size, flags=layout, blobDetector=detector)
    if not good and board.staggered:  # a board seen at a slant
        good, centres = cv2.findCirclesGrid(
            smooth, size, flags=layout | cv2.CALIB_CB_CLUSTERING, blobDetector=detector
        )
    if not good or centres is None or len(centres) != board.columns * board.rows:
        return None
    return _centroids(grey, centres.reshape(-1, 2).astype(np.float64), board)


def _centroids(grey: NDArray[np.uint8], centres: Points, board: Board) -> Points:
    """Each centre as the centroid of the darkness around it: steadier under noise than the blob's outline."""
    radius = 0.48 * _spacing(centres, board)
    refined = centres
    for _ in range(3):
        moved = []
        for u, v in refined:
            u0, v0 = round(float(u)), round(float(v))
            reach = int(radius) + 1
            rows = slice(max(0, v0 - reach), v0 + reach + 1)
            columns = slice(max(0, u0 - reach), u0 + reach + 1)
            window = grey[rows, columns].astype(np.float64)
            y, x = np.mgrid[rows.start : rows.start + window.shape[0], columns.start : columns.start + window.shape[1]]
            inside = (x - u) ** 2 + (y - v) ** 2 <= radius**2
            rim = inside & ((x - u) ** 2 + (y - v) ** 2 >= (0.85 * radius) ** 2)
            weight = np.where(inside, np.clip(np.median(window[rim]) - window, 0.0, None), 0.0)
            total = weight.sum()
            moved.append(((weight * x).sum() / total, (weight * y).sum() / total) if total > 0 else (u, v))
        refined = np.array(moved)
    return refined


def _spacing(points: Points, board: Board) -> float:
    """The smallest distance between neighbours, in pixels."""
    grid = points.reshape(board.rows, board.columns, 2)
    along = np.linalg.norm(np.diff(grid, axis=1), axis=2).min()
    across = np.linalg.norm(np.diff(grid, axis=0), axis=2).min()
    return float(min(along, across))
