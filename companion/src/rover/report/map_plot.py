"""The map of a run as a plot: what was seen, what was found, where the rover went."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.report.canvas import Canvas, draw_text, hatched, text_width
from rover.report.legend import LEGEND_HEIGHT_PX, draw_legend, draw_title
from rover.report.palette import (
    FAINT,
    GOAL,
    INK,
    LAUNCH,
    OBSTACLE,
    PAPER,
    PATH,
    UNMEASURED,
    UNSEEN,
    WHITE,
    ZONE,
    false_colour,
    temperature_span,
)
from rover.report.result import DetectionResult, GoalKind, GoalResult, ObstacleSource, RunResult

# Left, top, right, bottom at least: axes, title, legend, axes.
MARGINS_PX = (84, 92, 356, 76)
# Travel between the arrow heads on the path.
ARROW_SPACING_PX = 170.0
# The area's longer side.
FIELD_PX = 1240


def draw_map(result: RunResult, field_pixels: int = FIELD_PX) -> NDArray[np.uint8]:
    """The whole plot, BGR uint8 (h, w, 3)."""
    scale = field_pixels / max(result.area_height, result.area_width)
    left, top, right, bottom = MARGINS_PX
    bottom = max(bottom, LEGEND_HEIGHT_PX - round(result.area_height * scale))  # a wide area is lower than the legend
    canvas = Canvas(result.area_width, result.area_height, scale, (left, top, right, bottom), PAPER)
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
    rows, columns = kelvin.shape
    side = max(rows, columns)  # cut off by the area's border it is no square, and must not be stretched into one
    above, before = (side - rows) // 2, (side - columns) // 2
    after = (side - rows - above, side - columns - before)
    square = cv2.copyMakeBorder(picture, above, after[0], before, after[1], cv2.BORDER_CONSTANT, value=UNSEEN)
    return np.asarray(cv2.resize(square, (size, size), interpolation=cv2.INTER_CUBIC), dtype=np.uint8)


def write_png(path: str, picture: NDArray[np.uint8]) -> None:
    """Writes a picture."""
    with open(path, "wb") as stream:
        stream.write(png_bytes(picture))


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """A picture as PNG."""
    done, data = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 6])
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
    measured = canvas.raster(known, layers.origin, layers.resolution, smooth=False)
    shown = canvas.raster(layers.seen, layers.origin, layers.resolution, smooth=False)
    picture = hatched(canvas.rows, canvas.columns)
    # Surveyed without a temperature: around the launch, where the operator has looked, and under known obstacles.
    picture[shown > 0] = UNMEASURED
    canvas.field[:] = np.where(measured[..., None] > 0, false_colour(temperature.astype(np.float32), span), picture)


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
        given = obstacle.source is ObstacleSource.GIVEN
        if given:
            canvas.disc(obstacle.x, obstacle.y, obstacle.radius, OBSTACLE, alpha=0.75)
        canvas.circle(obstacle.x, obstacle.y, obstacle.radius, WHITE, 3)
        canvas.circle(obstacle.x, obstacle.y, obstacle.radius, OBSTACLE, 2)


def _path(canvas: Canvas, result: RunResult) -> None:
    points = result.path[:, 1:3]
    canvas.line(points, INK, 8)
    canvas.line(points, PATH, 4)
    for index in _arrow_indices(points, spacing=ARROW_SPACING_PX / canvas.scale):
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
    shape = np.array([[16.0, 0.0], [-11.0, 12.0], [-11.0, -12.0]]) / canvas.scale
    points = shape @ np.array([[c, s], [-s, c]]) + (x, y)
    canvas.polygon(points, PATH)
    canvas.line(points, INK, 2, closed=True)


def _launch(canvas: Canvas, result: RunResult) -> None:
    launch = result.launch
    c, s = math.cos(launch.heading), math.sin(launch.heading)
    shape = np.array([[28.0, 0.0], [-18.0, 18.0], [-9.0, 0.0], [-18.0, -18.0]]) / canvas.scale
    points = shape @ np.array([[c, s], [-s, c]]) + (launch.x, launch.y)
    canvas.polygon(points, LAUNCH)
    canvas.line(points, WHITE, 2, closed=True)
    if result.final_pose is not None:
        canvas.circle(result.final_pose.x, result.final_pose.y, result.robot_radius, WHITE, 5)
        canvas.circle(result.final_pose.x, result.final_pose.y, result.robot_radius, LAUNCH, 3)


def _goal(canvas: Canvas, goal: GoalResult) -> None:
    half = (14.0 if goal.kind is GoalKind.OPERATOR else 10.0) / canvas.scale
    diamond = np.array([[0.0, half], [half, 0.0], [0.0, -half], [-half, 0.0]])
    corners = diamond + np.array([goal.x, goal.y])
    canvas.polygon(corners, GOAL if goal.reached else WHITE)
    canvas.line(corners, WHITE if goal.reached else GOAL, 2, closed=True)
    if goal.kind is GoalKind.OPERATOR:
        canvas.badge(goal.x, goal.y, f"G{goal.id}", GOAL, 9.0, 18)


def _detection(canvas: Canvas, detection: DetectionResult) -> None:
    # At least as large as the dot, and never beyond the picture: a filter that lost its way may say anything.
    furthest = max(canvas.columns, canvas.rows) / canvas.scale
    sigma = min(max(detection.sigma, 4.0 / canvas.scale), furthest) if math.isfinite(detection.sigma) else furthest
    for colour, width in ((WHITE, 5), (ZONE, 2)):
        canvas.circle(detection.x, detection.y, sigma, colour, width)
    canvas.disc(detection.x, detection.y, 5.0 / canvas.scale, WHITE)
    canvas.disc(detection.x, detection.y, 3.5 / canvas.scale, ZONE)
    # The plate starts on the ring, so that it hides neither the place nor its uncertainty.
    canvas.badge(
        detection.x, detection.y, f"{detection.id}", ZONE, float(np.clip(0.75 * sigma * canvas.scale, 9.0, 40.0)), 22
    )


def _frame(canvas: Canvas, result: RunResult) -> None:
    """Border and axes in metres."""
    width, height = result.area_width, result.area_height
    first = (canvas.left - 1, canvas.top - 1)
    cv2.rectangle(canvas.image, first, (canvas.left + canvas.columns, canvas.top + canvas.rows), INK, 2)
    step = _tick_step(max(width, height))
    for index in range(int(width / step + 1e-9) + 1):
        column, row = canvas.pixel(index * step, 0.0)
        cv2.line(canvas.image, (round(column), round(row)), (round(column), round(row) + 8), INK, 2, cv2.LINE_AA)
        label = f"{index * step:g}"
        start = round(column) - text_width(label, 18, bold=False) // 2
        draw_text(canvas.image, label, (start, round(row) + 32), FAINT, 18)
    for index in range(int(height / step + 1e-9) + 1):
        column, row = canvas.pixel(0.0, index * step)
        cv2.line(canvas.image, (round(column) - 8, round(row)), (round(column), round(row)), INK, 2, cv2.LINE_AA)
        label = f"{index * step:g}"
        start = round(column) - 16 - text_width(label, 18, bold=False)
        draw_text(canvas.image, label, (start, round(row) + 7), FAINT, 18)
    column, row = canvas.pixel(width, 0.0)
    draw_text(canvas.image, "x in m", (round(column) - 48, round(row) + 60), FAINT, 18)
    column, row = canvas.pixel(0.0, height)
    draw_text(canvas.image, "y in m", (round(column) - 74, round(row) - 12), FAINT, 18)


def _tick_step(extent: float) -> float:
    """Distance of the axis marks: 1, 2 or 5 times a power of ten, 4 to 10 of them."""
    for step in (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0):
        if extent / step <= 10.0:
            return step
    return 50.0
