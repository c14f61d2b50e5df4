"""What a mission may be expected to take: by how fast earlier runs of the same folder surveyed, never by a guess."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import Any

from rover.console.runs import list_folders, read_summary
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.area_masks import wanted
from rover.mission.config import Mission

# Less surveyed than this says nothing about the pace, m².
LEAST_M2 = 1.0
MAX_RUNS = 20


def estimate(mission: Mission, runs: Path) -> dict[str, Any]:
    """area_m2, and duration_s, energy_wh and coverage, None while no earlier run tells them."""
    grid = SurveyGrid(mission.area.width, mission.area.height, 0.05)
    area = float(wanted(mission.area, grid.shape, grid.resolution).sum()) * grid.resolution**2
    pack = mission.rover.vehicle.pack
    paces, shares = _earlier(runs)
    duration = area / median(paces) if paces else None
    return {
        "area_m2": round(area, 2),
        "duration_s": None if duration is None else round(duration),
        "energy_wh": None if duration is None else round(duration * pack.power_w / 3600.0, 2),
        "battery_wh": pack.capacity_wh,
        "coverage": median(shares) if shares else None,
        "runs": len(paces),
    }


def _earlier(runs: Path) -> tuple[list[float], list[float]]:
    """Square metres a second, and coverage, of the last runs that surveyed anything to their end."""
    paces, shares = [], []
    for folder in list_folders(runs)[:MAX_RUNS]:
        summary = read_summary(folder)
        surveyed, lasted = summary.get("surveyed_m2"), summary.get("duration_s")
        if summary.get("status") in ("done", "partial") and surveyed and lasted and surveyed >= LEAST_M2:
            paces.append(float(surveyed) / float(lasted))
            if summary.get("coverage") is not None:
                shares.append(float(summary["coverage"]))
    return paces, shares
