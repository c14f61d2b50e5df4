"""The map of a run as a picture: what was seen, what was found, where the rover went."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.report.canvas import Canvas, draw_text, hatched
from rover.report.legend import draw_legend, draw_title
from rover.report.palette import (
    FAINT,
    GOAL,
    INK,
    LAUNCH,
    OBSTACLE,
    PAPER,
    PATH,
    WHITE,
    ZONE,
    false_colour,
    temperature_span,
)
from rover.report.result import DetectionResult, GoalResult, RunResult

MARGINS = (84, 92, 356, 76)
"""Left, top, right, bottom in pixels: axes, title, legend, axes."""

FIELD_PIXELS = 1240
"""Pixels of the area's longer side."""


def draw_map(result: RunResult, field_pixels: int = FIELD_PIXELS) -> NDArray[np.uint8]:
    """The whole picture, BGR uint8 (h, w, 3)."""
    scale = field_pixels / max(result.area_height, result.area_width)
    canvas = Canvas(result.area_width, result.area_height, scale, MARGINS, PAPER)
    span = temperature_span(result.layers.temperature)
    _ground(canvas, result, span)
    _occupied(canvas, result)
    _zones(canvas, result)
    _obstacles(canvas, result)
    _path(canvas, result)
    _launch(canvas, result)
    for goal in result.goals:
        _goal(canvas, goal)
    for detection in result.detections:
        _detection(canvas, detection)
    _frame(canvas, result)
    draw_title(canvas, result)
    draw_legend(canvas, result, span)
    return canvas.image


def thumbnail(kelvin: NDArray[np.float32], size: int = 112) -> NDArray[np.uint8]:
    """A piece of ground around an indication as a small square picture, its own contrast stretched, BGR."""
    low, high = temperature_span(kelvin)
    picture = false_colour(kelvin, (low, high))
    return np.asarray(cv2.resize(picture, (size, size), interpolation=cv2.INTER_CUBIC), dtype=np.uint8)


def write_png(path: str, picture: NDArray[np.uint8]) -> None:
    """Writes a picture."""
    with open(path, "wb") as stream:
        stream.write(png_bytes(picture))


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """A picture as PNG."""
    done, data = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    if not done:
        raise ValueError("the picture cannot be encoded as PNG")
    return bytes(data)


def _ground(canvas: Canvas, result: RunResult, span: tuple[float, float]) -> None:
    layers = result.layers
    known = np.isfinite(layers.temperature) & layers.seen
    # Unknown cells take the mean before resampling, so that they do not bleed into their neighbours.
    mean = float(layers.temperature[known].mean()) if known.any() else 293.0
    filled = np.where(known, layers.temperature, mean).astype(np.float32)
    temperature = canvas.raster(filled, layers.origin, layers.resolution, smooth=True)
    seen = canvas.raster(known, layers.origin, layers.resolution, smooth=False)
    picture = false_colour(temperature.astype(np.float32), span)
    canvas.field[:] = np.where(seen[..., None] > 0, picture, hatched(canvas.rows, canvas.columns))


def _occupied(canvas: Canvas, result: RunResult) -> None:
    layers = result.layers
    occupied = canvas.raster(layers.occupied, layers.origin, layers.resolution, smooth=False) > 0
    shade = np.asarray(OBSTACLE, dtype=np.float32)
    field = canvas.field
    field[occupied] = np.round(0.45 * field[occupied] + 0.55 * shade).astype(np.uint8)


def _zones(canvas: Canvas, result: RunResult) -> None:
    for detection in result.detections:
        canvas.disc(detection.x, detection.y, detection.zone_radius, ZONE, alpha=0.22)
    for detection in result.detections:
        canvas.circle(detection.x, detection.y, detection.zone_radius, ZONE, 2)


def _obstacles(canvas: Canvas, result: RunResult) -> None:
    for obstacle in result.obstacles:
        given = obstacle.source == "given"
        if given:
            canvas.disc(obstacle.x, obstacle.y, obstacle.radius, OBSTACLE, alpha=0.75)
        canvas.circle(obstacle.x, obstacle.y, obstacle.radius, WHITE, 3)
        canvas.circle(obstacle.x, obstacle.y, obstacle.radius, OBSTACLE, 2)


def _path(canvas: Canvas, result: RunResult) -> None:
    points = result.path[:, 1:3]
    canvas.line(points, INK, 7)
    canvas.line(points, PATH, 3)
    for index in _arrow_indices(points, spacing=0.6):
        x, y = points[index]
        dx, dy = points[min(index + 2, len(points) - 1)] - points[max(index - 2, 0)]
        _arrow_head(canvas, float(x), float(y), math.atan2(dy, dx))


def _arrow_indices(points: NDArray[np.float64], spacing: float) -> list[int]:
    """Indices of points that lie `spacing` metres of travel apart."""
    if len(points) < 8:
        return []
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    marks = np.arange(0.5 * spacing, travelled[-1], spacing)
    return [int(index) for index in np.searchsorted(travelled, marks)]


def _arrow_head(canvas: Canvas, x: float, y: float, heading: float) -> None:
    c, s = math.cos(heading), math.sin(heading)
    shape = np.array([[0.035, 0.0], [-0.025, 0.026], [-0.025, -0.026]])
    points = shape @ np.array([[c, s], [-s, c]]) + (x, y)
    canvas.polygon(points, PATH)
    canvas.line(points, INK, 1, closed=True)


def _launch(canvas: Canvas, result: RunResult) -> None:
    launch = result.launch
    c, s = math.cos(launch.heading), math.sin(launch.heading)
    shape = np.array([[0.09, 0.0], [-0.06, 0.06], [-0.03, 0.0], [-0.06, -0.06]])
    points = shape @ np.array([[c, s], [-s, c]]) + (launch.x, launch.y)
    canvas.polygon(points, LAUNCH)
    canvas.line(points, WHITE, 2, closed=True)
    if result.final_pose is not None:
        canvas.circle(result.final_pose.x, result.final_pose.y, result.robot_radius, WHITE, 5)
        canvas.circle(result.final_pose.x, result.final_pose.y, result.robot_radius, LAUNCH, 3)


def _goal(canvas: Canvas, goal: GoalResult) -> None:
    half = 0.035 if goal.kind == "operator" else 0.024
    corners = np.array([[0.0, half], [half, 0.0], [0.0, -half], [-half, 0.0]]) * 1.3 + (goal.x, goal.y)
    canvas.polygon(corners, GOAL if goal.reached else WHITE)
    canvas.line(corners, WHITE if goal.reached else GOAL, 2, closed=True)
    if goal.kind == "operator":
        canvas.label(goal.x, goal.y, f"G{goal.id}", GOAL, (16, 24), 20)


def _detection(canvas: Canvas, detection: DetectionResult) -> None:
    canvas.circle(detection.x, detection.y, max(detection.sigma, 0.004), WHITE, 4)
    canvas.circle(detection.x, detection.y, max(detection.sigma, 0.004), ZONE, 2)
    arm = 0.028
    for dx, dy in ((arm, arm), (arm, -arm)):
        cross = np.array([[detection.x - dx, detection.y - dy], [detection.x + dx, detection.y + dy]])
        canvas.line(cross, WHITE, 7)
        canvas.line(cross, ZONE, 3)
    canvas.label(detection.x, detection.y, f"{detection.id}", ZONE, (14, -14), 26)


def _frame(canvas: Canvas, result: RunResult) -> None:
    """Border, axes in metres, scale bar."""
    width, height = result.area_width, result.area_height
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    canvas.line(corners, INK, 2, closed=True)
    step = _tick_step(max(width, height))
    for index in range(int(width / step + 1e-9) + 1):
        column, row = canvas.pixel(index * step, 0.0)
        cv2.line(canvas.image, (round(column), round(row)), (round(column), round(row) + 8), INK, 2, cv2.LINE_AA)
        draw_text(canvas.image, f"{index * step:g}", (round(column) - 8, round(row) + 32), FAINT, 18)
    for index in range(int(height / step + 1e-9) + 1):
        column, row = canvas.pixel(0.0, index * step)
        cv2.line(canvas.image, (round(column) - 8, round(row)), (round(column), round(row)), INK, 2, cv2.LINE_AA)
        draw_text(canvas.image, f"{index * step:g}", (round(column) - 44, round(row) + 7), FAINT, 18)
    column, row = canvas.pixel(width, 0.0)
    draw_text(canvas.image, "x / m", (round(column) - 48, round(row) + 60), FAINT, 18)
    column, row = canvas.pixel(0.0, height)
    draw_text(canvas.image, "y / m", (round(column) - 74, round(row) - 12), FAINT, 18)


def _tick_step(extent: float) -> float:
    """Distance of the axis marks: 1, 2 or 5 times a power of ten, 4 to 10 of them."""
    for step in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0):
        if extent / step <= 10.0:
            return step
    return 50.0
