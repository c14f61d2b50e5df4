"""Title and legend of the map: what the marks mean, how warm the colours are, how long a metre is."""

from __future__ import annotations

import cv2
import numpy as np

from rover.capture.radiometry import ZERO_CELSIUS
from rover.report.canvas import Canvas, draw_text, hatched
from rover.report.palette import (
    COLORMAP,
    FAINT,
    GOAL,
    INK,
    LAUNCH,
    OBSTACLE,
    PATH,
    UNMEASURED,
    WHITE,
    ZONE,
)
from rover.report.result import RunResult

# Height of a line of the legend.
ROW_PX = 46
# From the top of the map to the legend's lower end.
LEGEND_HEIGHT_PX = 860


def draw_title(canvas: Canvas, result: RunResult) -> None:
    """Name and outcome above the map."""
    place = f"{result.site.name}, " if result.site.name else ""
    text = f"{place}mission {result.mission}: {result.status.replace('_', ' ')}"
    draw_text(canvas.image, text, (canvas.left, 40), INK, 28, bold=True)
    count = len(result.detections)
    counts = (
        f"{count} indication{'' if count == 1 else 's'}, {result.surveyed_area:.1f} of "
        f"{result.area_m2:.1f} m2 surveyed, {result.distance:.1f} m driven"
    )
    draw_text(canvas.image, counts, (canvas.left, 70), FAINT, 18)


def draw_legend(canvas: Canvas, result: RunResult, span: tuple[float, float]) -> None:
    """Column of explanations at the right of the map."""
    image = canvas.image
    column = canvas.left + canvas.columns + 28
    row = canvas.top + 24
    if result.identities.simulated:
        draw_text(image, "SIMULATED FIELD", (column, row), ZONE, 20, bold=True)
    row += 48
    _temperature_bar(canvas, column, row, span)
    row += 120
    marks = (
        (_mark_detection, "indication, ring: 1 sigma"),
        (_mark_zone, "keep-out zone"),
        (_mark_goal, "goal reached"),
        (_mark_open_goal, "goal not reached"),
        (_mark_path, "driven path"),
        (_mark_launch, "launch"),
        (_mark_end, "where the rover ended"),
        (_mark_obstacle, "obstacle"),
        (_mark_unmeasured, "surveyed, no temperature"),
        (_mark_unseen, "not surveyed"),
    )
    for mark, text in marks:
        mark(image, column + 20, row)
        draw_text(image, text, (column + 54, row + 7), INK, 18)
        row += ROW_PX
    _scale_bar(canvas, column, row + 30)
    _directions(canvas, column, row + 90)


def _temperature_bar(canvas: Canvas, column: int, row: int, span: tuple[float, float]) -> None:
    ramp = np.tile(np.linspace(0, 255, 260).astype(np.uint8), (22, 1))
    bar = cv2.applyColorMap(ramp, COLORMAP)
    canvas.image[row + 16 : row + 38, column : column + 260] = bar
    cv2.rectangle(canvas.image, (column, row + 16), (column + 260, row + 38), INK, 1)
    draw_text(canvas.image, "ground temperature", (column, row + 4), INK, 18)
    low, high = span
    draw_text(canvas.image, f"{low - ZERO_CELSIUS:.1f} deg C", (column, row + 62), FAINT, 17)
    draw_text(canvas.image, f"{high - ZERO_CELSIUS:.1f} deg C", (column + 176, row + 62), FAINT, 17)


def _scale_bar(canvas: Canvas, column: int, row: int) -> None:
    length = next(value for value in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0) if value * canvas.scale >= 90)
    end = column + round(length * canvas.scale)
    cv2.line(canvas.image, (column, row), (end, row), INK, 3, cv2.LINE_AA)
    for x in (column, end):
        cv2.line(canvas.image, (x, row - 8), (x, row + 8), INK, 3, cv2.LINE_AA)
    draw_text(canvas.image, f"{length:g} m", (column, row - 16), INK, 18)


def _directions(canvas: Canvas, column: int, row: int) -> None:
    """The axes of the map frame."""
    base = (column + 14, row + 70)
    for tip, text, place in (
        ((column + 84, row + 70), "x", (column + 92, row + 77)),
        ((column + 14, row), "y", (column + 28, row + 6)),
    ):
        cv2.arrowedLine(canvas.image, base, tip, INK, 2, cv2.LINE_AA, tipLength=0.18)
        draw_text(canvas.image, text, place, INK, 18)
    draw_text(canvas.image, "map frame", (column + 120, row + 77), FAINT, 17)


Image = np.ndarray


def _mark_detection(image: Image, x: int, y: int) -> None:
    cv2.circle(image, (x, y), 11, ZONE, 2, cv2.LINE_AA)
    cv2.circle(image, (x, y), 4, ZONE, -1, cv2.LINE_AA)


def _mark_zone(image: Image, x: int, y: int) -> None:
    cv2.circle(image, (x, y), 16, (205, 202, 246), -1, cv2.LINE_AA)
    cv2.circle(image, (x, y), 16, ZONE, 2, cv2.LINE_AA)


def _diamond(x: int, y: int) -> np.ndarray:
    return np.array([[x, y - 13], [x + 13, y], [x, y + 13], [x - 13, y]], dtype=np.int32).reshape(-1, 1, 2)


def _mark_goal(image: Image, x: int, y: int) -> None:
    cv2.fillPoly(image, [_diamond(x, y)], GOAL, cv2.LINE_AA)


def _mark_open_goal(image: Image, x: int, y: int) -> None:
    cv2.fillPoly(image, [_diamond(x, y)], WHITE, cv2.LINE_AA)
    cv2.polylines(image, [_diamond(x, y)], True, GOAL, 2, cv2.LINE_AA)


def _mark_path(image: Image, x: int, y: int) -> None:
    cv2.line(image, (x - 18, y), (x + 18, y), INK, 8, cv2.LINE_AA)
    cv2.line(image, (x - 18, y), (x + 18, y), PATH, 4, cv2.LINE_AA)
    head = np.array([[x + 11, y], [x - 7, y - 9], [x - 7, y + 9]], dtype=np.int32).reshape(-1, 1, 2)
    cv2.fillPoly(image, [head], PATH, cv2.LINE_AA)
    cv2.polylines(image, [head], True, INK, 2, cv2.LINE_AA)


def _mark_launch(image: Image, x: int, y: int) -> None:
    shape = np.array([[x, y - 15], [x + 10, y + 11], [x, y + 5], [x - 10, y + 11]], dtype=np.int32)
    cv2.fillPoly(image, [shape.reshape(-1, 1, 2)], LAUNCH, cv2.LINE_AA)


def _mark_end(image: Image, x: int, y: int) -> None:
    cv2.circle(image, (x, y), 15, LAUNCH, 3, cv2.LINE_AA)


def _mark_obstacle(image: Image, x: int, y: int) -> None:
    cv2.circle(image, (x, y), 15, (170, 162, 156), -1, cv2.LINE_AA)
    cv2.circle(image, (x, y), 15, OBSTACLE, 2, cv2.LINE_AA)


def _mark_unmeasured(image: Image, x: int, y: int) -> None:
    image[y - 14 : y + 14, x - 18 : x + 18] = UNMEASURED
    cv2.rectangle(image, (x - 18, y - 14), (x + 18, y + 14), FAINT, 1)


def _mark_unseen(image: Image, x: int, y: int) -> None:
    image[y - 14 : y + 14, x - 18 : x + 18] = hatched(28, 36, spacing=9)
    cv2.rectangle(image, (x - 18, y - 14), (x + 18, y + 14), FAINT, 1)
