"""A plot of a piece of the map: metres in, anti-aliased marks out."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.report.palette import HATCH, INK, UNSEEN, WHITE, Colour

# Bits of a fraction of a pixel that OpenCV's drawing calls take.
SHIFT = 4

Raster = NDArray[Any]


class Canvas:
    """A BGR image with the map's rectangle (0, 0)–(width, height) in it; y points up.

    left, top, right, bottom: margins in pixels. scale: pixels a metre. What is drawn at a place of the map is cut off
    at the map's border: a zone that reaches beyond the area must not cover axes or legend.
    """

    def __init__(
        self, width: float, height: float, scale: float, margins: tuple[int, int, int, int], paper: Colour
    ) -> None:
        self.left, self.top, right, bottom = margins
        self.scale = scale
        self.columns, self.rows = round(width * scale), round(height * scale)
        shape = (self.rows + self.top + bottom, self.columns + self.left + right, 3)
        self.image: NDArray[np.uint8] = np.full(shape, paper, dtype=np.uint8)

    @property
    def field(self) -> NDArray[np.uint8]:
        """View of the map's rectangle."""
        return self.image[self.top : self.top + self.rows, self.left : self.left + self.columns]

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Column and row of a point of the map in the whole image."""
        return self.left + x * self.scale, self.top + self.rows - y * self.scale

    def raster(self, cells: Raster, origin: tuple[float, float], resolution: float, smooth: bool) -> Raster:
        """A raster of the map (row 0 at the bottom), resampled to the pixels of `field`; 0 outside of it."""
        # Affine map from a pixel of the field to a cell: centres lie at +0.5 on both sides.
        step = 1.0 / (self.scale * resolution)
        matrix = np.array(
            [
                [step, 0.0, 0.5 * step - origin[0] / resolution - 0.5],
                [0.0, -step, (self.rows - 0.5) * step - origin[1] / resolution - 0.5],
            ]
        )
        flags = (cv2.INTER_LINEAR if smooth else cv2.INTER_NEAREST) | cv2.WARP_INVERSE_MAP
        source: Raster = cells.astype(np.float32 if smooth else np.uint8)
        border = cv2.BORDER_REPLICATE if smooth else cv2.BORDER_CONSTANT
        return np.asarray(cv2.warpAffine(source, matrix, (self.columns, self.rows), flags=flags, borderMode=border))

    def disc(self, x: float, y: float, radius: float, colour: Colour, alpha: float = 1.0) -> None:
        """A filled disc; `radius` in metres."""
        field = self.field
        overlay = field if alpha >= 1.0 else field.copy()
        cv2.circle(overlay, self._fixed(x, y), self._length(radius * self.scale), colour, -1, cv2.LINE_AA, SHIFT)
        if overlay is not field:
            cv2.addWeighted(overlay, alpha, field, 1.0 - alpha, 0.0, field)

    def circle(self, x: float, y: float, radius: float, colour: Colour, width: int = 2) -> None:
        """A circle; `radius` in metres."""
        cv2.circle(self.field, self._fixed(x, y), self._length(radius * self.scale), colour, width, cv2.LINE_AA, SHIFT)

    def line(self, points: NDArray[np.float64], colour: Colour, width: int = 2, closed: bool = False) -> None:
        """A polyline through points (N, 2) of the map."""
        if len(points) == 0:
            return
        fixed = self._fixed_all(points)
        cv2.polylines(self.field, [fixed], closed, colour, width, cv2.LINE_AA, SHIFT)

    def polygon(self, points: NDArray[np.float64], colour: Colour) -> None:
        """A filled polygon of points (N, 2) of the map."""
        fixed = self._fixed_all(points)
        cv2.fillPoly(self.field, [fixed], colour, cv2.LINE_AA, SHIFT)

    def badge(self, x: float, y: float, text: str, colour: Colour, distance: float, size: int = 20) -> None:
        """White text on a plate at the upper right of a point of the map, `distance` pixels away, inside the map."""
        column, row = self.pixel(x, y)
        width = text_width(text, size)
        left = min(max(round(column + distance), self.left + 2), self.left + self.columns - width - 14)
        bottom = min(max(round(row - distance), self.top + size + 12), self.top + self.rows - 2)
        corner, opposite = (left, bottom - size - 8), (left + width + 12, bottom)
        cv2.rectangle(self.image, corner, opposite, colour, -1)
        cv2.rectangle(self.image, corner, opposite, WHITE, 1, cv2.LINE_AA)
        draw_text(self.image, text, (left + 6, bottom - 6), WHITE, size, bold=True)

    def _fixed(self, x: float, y: float) -> tuple[int, int]:
        """A point of the map in fractions of the field's pixels."""
        return round(x * self.scale * (1 << SHIFT)), round((self.rows - y * self.scale) * (1 << SHIFT))

    def _fixed_all(self, points: NDArray[np.float64]) -> NDArray[np.int32]:
        pixels = points * (self.scale, -self.scale) + np.array([0.0, self.rows])
        return np.asarray(np.round(pixels * (1 << SHIFT)), dtype=np.int32).reshape(-1, 1, 2)

    @staticmethod
    def _length(pixels: float) -> int:
        return max(1, round(pixels * (1 << SHIFT)))


def draw_text(
    image: NDArray[np.uint8],
    text: str,
    position: tuple[int, int],
    colour: Colour = INK,
    size: int = 20,
    bold: bool = False,
) -> None:
    """Text with its baseline's left end at `position`; `size`: height of the letters in pixels, about."""
    cv2.putText(image, text, position, cv2.FONT_HERSHEY_SIMPLEX, size / 30.0, colour, _stroke(size, bold), cv2.LINE_AA)


def text_width(text: str, size: int = 20, bold: bool = True) -> int:
    """Pixels that a text takes from left to right."""
    (width, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size / 30.0, _stroke(size, bold))
    return int(width)


def _stroke(size: int, bold: bool) -> int:
    return max(1, round(size / 15.0)) + int(bold)


def hatched(rows: int, columns: int, spacing: int = 14) -> NDArray[np.uint8]:
    """Diagonal hatching, for ground that nobody has looked at."""
    image = np.full((rows, columns, 3), UNSEEN, dtype=np.uint8)
    for start in range(-rows, columns, spacing):
        cv2.line(image, (start, rows), (start + rows, 0), HATCH, 1, cv2.LINE_AA)
    return image
