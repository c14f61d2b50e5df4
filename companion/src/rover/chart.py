"""Marks on a page (lines, areas, text) that become SVG or PNG, and axes with round ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from html import escape

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# PNG pixels for each unit of the page.
PNG_SCALE = 2.0
# OpenCV's drawing calls take coordinates in 1/16 of a pixel.
SUBPIXEL_BITS = 4
# Height of the letters of OpenCV's simplex font at scale 1, pixels.
FONT_HEIGHT_PX = 21.0
# Sides of the polygon that stands for a circle.
CIRCLE_SIDES = 64


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline through points (N, 2) of the page; `dash`: length of dashes and gaps, 0 for a solid line."""

    points: Array
    colour: str
    width: float = 1.0
    dash: float = 0.0


@dataclass(frozen=True, eq=False)
class Area:
    """Filled polygons, each of points (N, 2) of the page."""

    polygons: list[Array]
    colour: str


@dataclass(frozen=True)
class Text:
    """A text whose baseline is at (x, y); `anchor`: start, middle or end; `upright`: reads from bottom to top."""

    x: float
    y: float
    text: str
    colour: str
    size: float = 12.0
    anchor: str = "start"
    upright: bool = False


@dataclass
class Page:
    """A white page, y downwards; its marks in the order of drawing."""

    width: int
    height: int
    marks: list[Line | Area | Text] = field(default_factory=list)

    def rectangle(self, left: float, top: float, width: float, height: float, colour: str) -> None:
        """The outline of a rectangle."""
        right, bottom = left + width, top + height
        corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom], [left, top]])
        self.marks.append(Line(corners, colour))

    def ring(self, x: float, y: float, radius: float, colour: str, width: float = 1.6) -> None:
        """The outline of a circle."""
        self.marks.append(Line(circle(x, y, radius), colour, width))

    def cross(self, x: float, y: float, colour: str, reach: float = 4.0) -> None:
        """A diagonal cross."""
        for rise in (-reach, reach):
            self.marks.append(Line(np.array([[x - reach, y - rise], [x + reach, y + rise]]), colour, 1.6))

    def svg(self) -> str:
        """The page as an SVG document."""
        size = f'width="{self.width}" height="{self.height}" viewBox="0 0 {self.width} {self.height}"'
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">',
            f'<rect width="{self.width}" height="{self.height}" fill="white"/>',
            *(_svg(mark) for mark in self.marks),
            "</svg>",
            "",
        ]
        return "\n".join(parts)

    def png(self) -> bytes:
        """The page as a PNG file of PNG_SCALE pixels a unit."""
        shape = (round(self.height * PNG_SCALE), round(self.width * PNG_SCALE), 3)
        image: NDArray[np.uint8] = np.full(shape, 255, dtype=np.uint8)
        for mark in self.marks:
            if isinstance(mark, Line):
                _draw_line(image, mark)
            elif isinstance(mark, Area):
                _draw_area(image, mark)
            else:
                _draw_text(image, mark)
        _, data = cv2.imencode(".png", image)
        return bytes(data.tobytes())


def ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round values between two bounds, at most `most` of them, 1, 2 or 5 times a power of ten apart."""
    span = max(high - low, 1e-9)
    power = 10.0 ** math.floor(math.log10(span / most))
    step = next(factor * power for factor in (1.0, 2.0, 5.0, 10.0, 20.0) if span / (factor * power) <= most - 1)
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    return [number * step for number in range(first, last + 1)]


def circle(x: float, y: float, radius: float) -> Array:
    """The circle as a closed polygon (N, 2)."""
    angles = np.linspace(0.0, 2.0 * math.pi, CIRCLE_SIDES + 1)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def _svg(mark: Line | Area | Text) -> str:
    if isinstance(mark, Line):
        return _svg_line(mark)
    return _svg_area(mark) if isinstance(mark, Area) else _svg_text(mark)


def _svg_area(area: Area) -> str:
    outlines = ("L".join(f"{x:.1f} {y:.1f}" for x, y in polygon.tolist()) for polygon in area.polygons)
    return f'<path d="{"".join(f"M{outline}Z" for outline in outlines)}" fill="{area.colour}"/>'


def _svg_line(line: Line) -> str:
    listed = " ".join(f"{x:.1f},{y:.1f}" for x, y in line.points.tolist())
    dash = f' stroke-dasharray="{line.dash:g}"' if line.dash else ""
    return f'<polyline points="{listed}" fill="none" stroke="{line.colour}" stroke-width="{line.width:g}"{dash}/>'


def _svg_text(text: Text) -> str:
    turn = f' transform="rotate(-90 {text.x:.1f} {text.y:.1f})"' if text.upright else ""
    place = f'x="{text.x:.1f}" y="{text.y:.1f}" font-size="{text.size:g}" text-anchor="{text.anchor}"'
    return f'<text {place} fill="{text.colour}"{turn}>{escape(text.text)}</text>'


def _bgr(colour: str) -> tuple[int, int, int]:
    return int(colour[5:7], 16), int(colour[3:5], 16), int(colour[1:3], 16)


def _draw_line(image: NDArray[np.uint8], line: Line) -> None:
    fixed = np.round(line.points * PNG_SCALE * (1 << SUBPIXEL_BITS)).astype(np.int32).reshape(-1, 1, 2)
    width = max(1, round(line.width * PNG_SCALE))
    pieces = [fixed]
    if line.dash:
        pieces = [
            np.round(piece * PNG_SCALE * (1 << SUBPIXEL_BITS)).astype(np.int32).reshape(-1, 1, 2)
            for piece in _dashes(line.points, line.dash)
        ]
    cv2.polylines(image, pieces, False, _bgr(line.colour), width, cv2.LINE_AA, SUBPIXEL_BITS)


def _draw_area(image: NDArray[np.uint8], area: Area) -> None:
    for polygon in area.polygons:
        fixed = np.round(polygon * PNG_SCALE * (1 << SUBPIXEL_BITS)).astype(np.int32).reshape(-1, 1, 2)
        cv2.fillPoly(image, [fixed], _bgr(area.colour), cv2.LINE_AA, SUBPIXEL_BITS)


def _dashes(points: Array, dash: float) -> list[Array]:
    """The drawn parts of a dashed polyline."""
    steps = np.diff(points, axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    starts = np.arange(0.0, way[-1], 2.0 * dash)
    found = []
    for start in starts.tolist():
        at = np.linspace(start, min(start + dash, way[-1]), 3)
        found.append(np.column_stack([np.interp(at, way, points[:, 0]), np.interp(at, way, points[:, 1])]))
    return found


def _draw_text(image: NDArray[np.uint8], text: Text) -> None:
    # OpenCV's fonts are ASCII.
    ascii_text = text.text.replace("²", "^2").replace("³", "^3").replace("×", "x").replace("–", "-")
    scale = text.size * PNG_SCALE * 0.7 / FONT_HEIGHT_PX
    font, stroke = cv2.FONT_HERSHEY_SIMPLEX, max(1, round(text.size * PNG_SCALE / 16.0))
    (width, height), baseline = cv2.getTextSize(ascii_text, font, scale, stroke)
    patch: NDArray[np.uint8] = np.full((height + baseline + 2, width + 2, 3), 255, dtype=np.uint8)
    cv2.putText(patch, ascii_text, (1, height + 1), font, scale, _bgr(text.colour), stroke, cv2.LINE_AA)
    back = {"start": 0.0, "middle": 0.5, "end": 1.0}[text.anchor] * width
    column, row = text.x * PNG_SCALE, text.y * PNG_SCALE
    left, top = round(column - back), round(row - height)
    if text.upright:
        patch = np.ascontiguousarray(np.rot90(patch))
        left, top = round(column - height), round(row + back - width)
    left, top = max(left, 0), max(top, 0)
    part = image[top : top + patch.shape[0], left : left + patch.shape[1]]
    np.minimum(part, patch[: part.shape[0], : part.shape[1]], out=part)
