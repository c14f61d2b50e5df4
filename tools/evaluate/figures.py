"""The figures of the field: F1, confusion, intervals, calibration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from rover_hil.campaign.intervals import binomial_interval, poisson_interval

# What the paper reports in its table 1: F1 of obstacle, surface and buried, per cent.
PAPER_F1 = {"obstacle": 90.8, "surface": 87.2, "buried": 88.3}


def f1(truth: NDArray[np.bool_], answer: NDArray[np.bool_]) -> float:
    """Harmonic mean of precision and recall; nan where nothing is true."""
    if not truth.any():
        return math.nan
    return float(2 * (truth & answer).sum() / (truth.sum() + answer.sum()))


def precision_recall(truth: NDArray[np.bool_], answer: NDArray[np.bool_]) -> tuple[float, float]:
    """Precision and recall."""
    hits = float((truth & answer).sum())
    return hits / max(float(answer.sum()), 1.0), hits / max(float(truth.sum()), 1.0)


def binomial(hits: int, trials: int) -> str:
    """Share with its exact 95 % interval."""
    if not trials:
        return "–"
    low, high = binomial_interval(hits, trials)
    return f"{hits / trials:.2f} [{low:.2f}, {high:.2f}]"


def poisson(events: int, exposure: float) -> str:
    """Rate with its exact 95 % interval (Garwood)."""
    low, high = poisson_interval(events, exposure)
    return f"{events / exposure:.3f} [{low:.3f}, {high:.3f}]"


def number(value: float) -> str:
    """Two decimals; a dash where there is nothing to measure."""
    return "–" if math.isnan(value) else f"{value:.2f}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])
