"""A result as a mission leaves it, made up but complete."""

from __future__ import annotations

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.report.result import (
    DetectionResult,
    GoalResult,
    Identities,
    Localization,
    MapLayers,
    ObstacleResult,
    RunResult,
    Safety,
    TimelineEntry,
    Unsurveyed,
    WallClock,
)


def make_layers(width: float = 3.0, height: float = 4.0, resolution: float = 0.02) -> MapLayers:
    """Smooth warm ground with two anomalies, a rock, and a strip and a shadow that were not seen."""
    rows, columns = round(height / resolution), round(width / resolution)
    y, x = np.mgrid[0:rows, 0:columns] * resolution
    rng = np.random.default_rng(4)
    kelvin = 305.0 + 1.2 * np.sin(1.7 * x) * np.cos(1.1 * y) + rng.normal(0.0, 0.15, x.shape)
    for cx, cy, contrast in ((1.1, 1.6, 3.5), (2.2, 2.9, 2.2), (2.3, 1.1, -1.4)):
        kelvin += contrast * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 0.006)
    occupied = (x - 0.7) ** 2 + (y - 2.7) ** 2 < 0.13**2
    kelvin[occupied] += 3.0
    seen = ~((y > 3.75) | ((x - 2.85) ** 2 + (y - 2.0) ** 2 < 0.3**2))
    return MapLayers((0.0, 0.0), resolution, np.where(seen, kelvin, np.nan).astype(np.float32), seen, occupied)


def make_result(**changes: object) -> RunResult:
    layers = make_layers()
    t = np.linspace(0.0, 140.0, 700)
    path = np.stack([t, 0.4 + 1.1 * (1 - np.cos(t / 50)), 0.4 + 2.6 * t / 140 + 0.25 * np.sin(t / 12)], axis=1)
    patch = layers.temperature[70:90, 45:65]
    values: dict[str, object] = {
        "mission": "demo",
        "status": "partial",
        "reason": "every goal is inspected but one: no way leads to it past the keep-out zones",
        "duration": 141.3,
        "distance": 9.81,
        "area_width": 3.0,
        "area_height": 4.0,
        "launch": Pose2(0.4, 0.4, 0.785),
        "path": path,
        "layers": layers,
        "identities": Identities("sitl", 7, "0.1.0", "0.1.0", "00abcdef", "Sitl", "0xdb53905e", "a" * 64, "b" * 64),
        "detections": (
            DetectionResult(1, "surface", 0.97, 1.1, 1.6, 0.021, 31, 0.2, 12.3, True, "", {"surface": 0.97}, patch),
            DetectionResult(2, "buried", 0.81, 2.2, 2.9, 0.034, 12, 0.2, 60.1, False, "no way to a place to look from"),
            DetectionResult(3, "buried", 0.66, 2.3, 1.1, 0.05, 5, 0.2, 88.0, True),
        ),
        "goals": (
            GoalResult(1, 2.0, 2.3, True, "operator", "", 80.2),
            GoalResult(2, 0.7, 1.6, True, "inspection", "", 30.0),
            GoalResult(3, 2.7, 3.4, False, "operator", "no way leads to it past the keep-out zones"),
        ),
        "obstacles": (ObstacleResult(0.7, 2.7, 0.14, "thermal"), ObstacleResult(2.6, 0.5, 0.15, "given")),
        "unsurveyed": (Unsurveyed(0.75, "outside what the camera reached"), Unsurveyed(0.28, "hidden by an obstacle")),
        "surveyed_area": 10.97,
        "safety": Safety(0, 0, 0.0, 0.083),
        "localization": Localization(0.021, 0.143, 410, 9, 0.011, 0.031),
        "link": {"frames_received": 27012.0, "lost": 0.0, "quality": 1.0, "clock_error_bound": 0.0004},
        "timeline": (TimelineEntry(0.0, "armed"), TimelineEntry(12.3, "indication 1 at (1.10, 1.60)")),
        "final_pose": Pose2(float(path[-1, 1]), float(path[-1, 2]), 1.0),
        "wall_clock": WallClock(20.1, 7.03),
        "out": "runs/demo",
    }
    return RunResult(**{**values, **changes})  # type: ignore[arg-type]


@pytest.fixture
def result() -> RunResult:
    return make_result()
