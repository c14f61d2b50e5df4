"""A result as a mission leaves it, made up but complete."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.geometry import Pose2
from rover.outcome import RunStatus
from rover.report.result import (
    DetectionResult,
    GoalKind,
    GoalResult,
    Identities,
    Localization,
    MapLayers,
    ObstacleResult,
    ObstacleSource,
    RunResult,
    Safety,
    TimelineEntry,
    Unsurveyed,
    WallClock,
)

RESOLUTION = 0.02
PLACES = (
    # id, class, p, x, y, sigma, views, first seen, inspected, why not, contrast in kelvin
    (1, "surface", 0.97, 1.12, 1.62, 0.021, 31, 12.3, True, "", 3.4),
    (2, "buried", 0.81, 2.22, 2.90, 0.034, 12, 60.1, False, "no way to a place to look from", 2.1),
    (4, "buried", 0.66, 2.31, 1.08, 0.052, 5, 88.0, True, "", 1.3),
    (5, "surface", 0.92, 0.52, 3.31, 0.018, 22, 101.5, True, "", -2.4),
    (9, "buried", 0.54, 1.70, 3.62, 0.061, 3, 133.0, False, "the mission ended before", 0.9),
)
ROCKS = ((0.72, 2.55, 0.13), (1.92, 1.95, 0.10), (1.35, 0.62, 0.08))
WAYPOINTS = (
    (0.45, 0.45), (0.85, 0.95), (0.75, 1.60), (0.78, 2.05), (1.25, 2.25), (1.60, 1.55), (1.80, 0.90), (2.02, 0.55),
    (1.72, 1.10), (1.50, 1.95), (1.62, 2.45), (1.70, 3.05), (1.25, 3.30), (0.98, 3.32), (1.25, 2.95), (1.45, 2.70),
)  # fmt: skip


def make_layers(width: float = 3.0, height: float = 4.0) -> MapLayers:
    """Mottled warm ground with an anomaly at every place, three rocks with their shadows, and unseen edges."""
    rows, columns = round(height / RESOLUTION), round(width / RESOLUTION)
    y, x = (np.mgrid[0:rows, 0:columns] + 0.5) * RESOLUTION
    rng = np.random.default_rng(4)
    kelvin = 305.0 + 0.8 * np.sin(1.7 * x) * np.cos(1.1 * y)
    for scale, amplitude in ((25, 1.4), (8, 0.8), (3, 0.5)):
        coarse = rng.normal(0.0, amplitude, (rows // scale + 2, columns // scale + 2)).astype(np.float32)
        kelvin += cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC)
    kelvin += rng.normal(0.0, 0.05, x.shape)
    for _, _, _, px, py, _, _, _, _, _, contrast in PLACES:
        kelvin += contrast * np.exp(-((x - px) ** 2 + (y - py) ** 2) / 0.004)
    occupied = np.zeros(x.shape, dtype=bool)
    seen = ~((y > 3.82 - 0.1 * np.sin(3.0 * x)) | ((x - 2.85) ** 2 + (y - 2.0) ** 2 < 0.33**2))
    for rx, ry, r in ROCKS:
        occupied |= (x - rx) ** 2 + (y - ry) ** 2 < r**2
        seen &= ((x - rx - 1.1 * r) ** 2 + (y - ry - 1.1 * r) ** 2 > (0.8 * r) ** 2) | occupied
    kelvin[occupied] += 3.0
    measured = seen & ((x - 0.45) ** 2 + (y - 0.45) ** 2 > 0.25**2)  # around the launch the operator has looked
    return MapLayers((0.0, 0.0), RESOLUTION, np.where(measured, kelvin, np.nan).astype(np.float32), seen, occupied)


def make_path() -> NDArray[np.float64]:
    """Straight lines between waypoints at 0.25 m/s, a pose every 0.1 s."""
    corners = np.array(WAYPOINTS)
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    times = np.arange(0.0, travelled[-1] / 0.25, 0.1)
    along = 0.25 * times
    return np.stack([times, *(np.interp(along, travelled, corners[:, axis]) for axis in (0, 1))], axis=1)


def cut(layers: MapLayers, x: float, y: float, half: int = 15) -> NDArray[np.float32]:
    """Kelvin around a place, row 0 at the top."""
    row, column = int(y / RESOLUTION), int(x / RESOLUTION)
    piece = layers.temperature[max(0, row - half) : row + half + 1, max(0, column - half) : column + half + 1]
    upright: NDArray[np.float32] = piece[::-1].copy()
    return upright


def make_detections(layers: MapLayers) -> tuple[DetectionResult, ...]:
    return tuple(
        DetectionResult(n, kind, p, x, y, sigma, views, 0.15, first, inspected, why, {kind: p}, cut(layers, x, y))
        for n, kind, p, x, y, sigma, views, first, inspected, why, _ in PLACES
    )


def make_result(**changes: object) -> RunResult:
    layers = make_layers()
    path = make_path()
    values: dict[str, object] = {
        "mission": "demo",
        "status": RunStatus.PARTIAL,
        "reason": "every goal is inspected but one: no way leads to it past the keep-out zones",
        "duration": 141.3,
        "distance": 9.81,
        "area_width": 3.0,
        "area_height": 4.0,
        "launch": Pose2(0.45, 0.45, 0.785),
        "path": path,
        "layers": layers,
        "identities": Identities("sitl", 7, "0.1.0", "0.1.0", "00abcdef", "Sitl", "db53905e", "a" * 12, "b" * 12),
        "detections": make_detections(layers),
        "goals": (
            GoalResult(1, 2.0, 2.3, True, GoalKind.OPERATOR, "", 80.2),
            GoalResult(2, 0.75, 1.6, True, GoalKind.INSPECTION, "", 30.0),
            GoalResult(3, 2.75, 3.4, False, GoalKind.OPERATOR, "no way leads to it past the keep-out zones"),
            GoalResult(4, 1.8, 2.6, False, GoalKind.INSPECTION, "no way to a place to look from"),
        ),
        "obstacles": (
            *(ObstacleResult(x, y, r, ObstacleSource.THERMAL) for x, y, r in ROCKS),
            ObstacleResult(2.6, 0.5, 0.15, ObstacleSource.GIVEN),
            ObstacleResult(2.62, 1.62, 0.06, ObstacleSource.THERMAL),
        ),
        "unsurveyed": (
            Unsurveyed(0.16, "inside a keep-out zone"),
            Unsurveyed(0.09, "hidden behind an obstacle from every viewpoint tried"),
            Unsurveyed(0.78, "out of view from all ground that the rover could reach"),
        ),
        "surveyed_area": 10.97,
        "safety": Safety(0, 0, 0.0, 0.083, 0),
        "localization": Localization(0.021, 0.143, 410, 9, 0.011, 0.031),
        "link": {
            "frames_received": 27012.0, "lost": 0.0, "firmware_lost": 0.0, "checksum_errors": 0.0,
            "segments_sent": 812.0, "segments_repeated": 3.0, "round_trip_median": 0.0021, "round_trip_p99": 0.0048,
            "clock_error_bound": 0.0004, "clock_drift": 1.2e-6, "quality": 1.0,
        },
        "timeline": (
            TimelineEntry(0.0, "armed"),
            TimelineEntry(12.3, "indication 1 at (1.12, 1.62)"),
            TimelineEntry(30.0, "inspected indication 1"),
            TimelineEntry(141.3, "disarmed"),
        ),
        "final_pose": Pose2(float(path[-1, 1]), float(path[-1, 2]), -1.0),
        "wall_clock": WallClock(20.1, 7.03),
        "out": "runs/demo",
    }  # fmt: skip
    return RunResult(**{**values, **changes})  # type: ignore[arg-type]
