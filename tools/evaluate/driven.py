"""Synthetic fields driven over: what is reported per place, Pd and false alarms per m², by depth, hour and soil."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import MINES
from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.place import Place
from rover_hil.ground import Mine
from rover_hil.referee import FAIR_CONTRAST_K

from tools.bench.detector import Driven, drive_all, reports
from tools.evaluate.figures import binomial, poisson, table
from tools.train.measure import f1_intervals, f1_scores

THRESHOLDS = (0.2, 0.3, 0.4, 0.5, 0.7, 0.9)
# One count per mine within its half-extent and this much more, metres.
HALO = 0.10
# From this probability on the rover reports, unless a mission says otherwise.
CHOSEN = EvidenceSettings().report_threshold
NOTHING = len(MINES)


def drives(model: Path, fields: int, first: int) -> list[Driven]:
    """The demo mission's fields in four soils at nine hours."""
    return drive_all(model, fields, first, True)


def curve(runs: list[Driven]) -> str:
    """Pd of mines with contrast and false alarms per m², by threshold."""
    area = sum(r.ground.area[0] * r.ground.area[1] for r in runs)
    rows = []
    for threshold in THRESHOLDS:
        every = [hit for r in runs for hit in _hits(r, threshold, 0.0)]
        visible = [hit for r in runs for hit in _hits(r, threshold, FAIR_CONTRAST_K)]
        false = sum(_false(r, threshold) for r in runs)
        rows.append(
            [
                f"{threshold:g}",
                binomial(sum(visible), len(visible)),
                binomial(sum(every), len(every)),
                poisson(false, area),
            ]
        )
    return table(["threshold", f"Pd, mines ≥ {FAIR_CONTRAST_K:g} K", "Pd, all mines", "false alarms per m²"], rows)


def places(runs: list[Driven]) -> str:
    """What mines with contrast are reported as at CHOSEN, and F1 per kind; 95 % intervals from fields drawn again."""
    by_field = np.array([_confusion(run) for run in runs])
    counts, intervals = by_field.sum(axis=0), f1_intervals(by_field)
    rows = []
    for name, row, score, (low, high) in zip((*MINES, "nothing"), counts, f1_scores(counts), intervals, strict=True):
        told = f"{score:.3f} [{low:.3f}, {high:.3f}]" if name in MINES else "–"
        rows.append([name, *(str(n) for n in row[:NOTHING]), str(row[NOTHING]) if name in MINES else "–", told])
    return table(["truth \\ reported as", *MINES, "nothing", "F1"], rows)


def _confusion(run: Driven) -> NDArray[np.int64]:
    """Counts (3, 3) of one field: mines by kind or nothing, against reports by kind or none."""
    counts = np.zeros((NOTHING + 1,) * 2, np.int64)
    told = reports(run, CHOSEN)
    for mine in run.ground.mines:
        if abs(mine.contrast_k) >= FAIR_CONTRAST_K:
            own = [place for place in told if _is_at(place, mine)]
            best = max(own, key=lambda place: place.mine_probability, default=None)
            counts[MINES.index(mine.kind), NOTHING if best is None else MINES.index(best.kind)] += 1
    for place in told:
        if not any(_is_at(place, mine) for mine in run.ground.mines):
            counts[NOTHING, MINES.index(place.kind)] += 1
    return counts


def _is_at(place: Place, mine: Mine) -> bool:
    """True where a report counts for the mine."""
    return math.hypot(place.x - mine.x, place.y - mine.y) <= mine.radius + HALO


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
    told = reports(run, threshold)
    return [any(_is_at(p, m) for p in told) for m in run.ground.mines if abs(m.contrast_k) >= contrast]


def _false(run: Driven, threshold: float) -> int:
    return sum(not any(_is_at(p, m) for m in run.ground.mines) for p in reports(run, threshold))
