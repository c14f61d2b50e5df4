"""Synthetic fields driven over: Pd and false alarms per m², by depth, hour and soil."""

from __future__ import annotations

import math
from pathlib import Path

from rover_hil.ground import Mine

from tools.bench.detector import CONTRAST_FLOOR, Driven, drive_all, reports
from tools.evaluate.figures import binomial, poisson, table

THRESHOLDS = (0.2, 0.35, 0.5, 0.65, 0.8)
# One count per mine within its half-extent and this much more, metres.
HALO = 0.10
CHOSEN = 0.5


def drives(model: Path, fields: int, first: int) -> list[Driven]:
    """The demo mission's fields in four soils at nine hours."""
    return drive_all(model, fields, first, True)


def curve(runs: list[Driven]) -> str:
    """Pd of mines with contrast and false alarms per m², by threshold."""
    area = sum(r.ground.area[0] * r.ground.area[1] for r in runs)
    rows = []
    for threshold in THRESHOLDS:
        every = [hit for r in runs for hit in _hits(r, threshold, 0.0)]
        visible = [hit for r in runs for hit in _hits(r, threshold, CONTRAST_FLOOR)]
        false = sum(_false(r, threshold) for r in runs)
        rows.append(
            [
                f"{threshold:g}",
                binomial(sum(visible), len(visible)),
                binomial(sum(every), len(every)),
                poisson(false, area),
            ]
        )
    return table(["threshold", f"Pd, mines ≥ {CONTRAST_FLOOR:g} K", "Pd, all mines", "false alarms per m²"], rows)


def split(runs: list[Driven]) -> str:
    """Pd of every mine at CHOSEN, by depth, hour and soil; those without contrast count as missed."""
    rows = []
    for title, key in (("depth", _depth), ("hour", _hour), ("soil", _soil)):
        groups: dict[str, list[bool]] = {}
        for run in runs:
            for mine, hit in zip(run.ground.mines, _hits(run, CHOSEN, 0.0), strict=True):
                groups.setdefault(key(run, mine), []).append(hit)
        rows += [[title, name, binomial(sum(hits), len(hits))] for name, hits in sorted(groups.items())]
    return table(["by", "", f"Pd at {CHOSEN:g}, all mines"], rows)


def _depth(_run: Driven, mine: Mine) -> str:
    return "surface" if mine.kind == "surface" else f"{100 * mine.depth:.0f} cm"


def _hour(run: Driven, _mine: Mine) -> str:
    return f"{run.ground.hour:04.1f} h"


def _soil(run: Driven, _mine: Mine) -> str:
    return run.ground.soil


def _hits(run: Driven, threshold: float, contrast: float) -> list[bool]:
    places = reports(run, threshold)
    return [
        any(math.hypot(p.x - m.x, p.y - m.y) <= m.radius + HALO for p in places)
        for m in run.ground.mines
        if abs(m.contrast_k) >= contrast
    ]


def _false(run: Driven, threshold: float) -> int:
    return sum(
        all(math.hypot(p.x - m.x, p.y - m.y) > m.radius + HALO for m in run.ground.mines)
        for p in reports(run, threshold)
    )
