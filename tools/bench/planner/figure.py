"""The comparison of figure 11: time and length of every planner on the paper's field, a box each, as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import numpy as np

LABELS, PANEL, ROW, TOP = 330, 330, 24, 40


def boxes(runs: Mapping[str, tuple[Sequence[float], Sequence[float]]], path: Path) -> None:
    """`runs`: milliseconds (drawn by their logarithm) and metres per planner.

    Whiskers are the 5th and the 95th percentile, the box the quartiles, the stroke the median.
    """
    height = TOP + ROW * len(runs) + 30
    width = LABELS + 2 * PANEL + 40
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
        f'font-size="12"><rect width="100%" height="100%" fill="white"/>'
    ]
    for number, name in enumerate(runs):
        parts.append(
            f'<text x="{LABELS - 10}" y="{TOP + ROW * (number + 0.66):.0f}" text-anchor="end">{escape(name)}</text>'
        )
    for panel, (title, logarithmic) in enumerate((("time, ms", True), ("length, m", False))):
        left = LABELS + panel * (PANEL + 20)
        columns = [np.percentile(values[panel], (5, 25, 50, 75, 95)) for values in runs.values()]
        columns = [np.log10(np.maximum(c, 1e-4)) if logarithmic else c for c in columns]
        low, high = math.floor(min(c[0] for c in columns)), math.ceil(max(c[4] for c in columns))

        def x(value: float, left: int = left, low: int = low, high: int = high) -> float:
            return left + PANEL * (value - low) / max(high - low, 1)

        parts.append(f'<text x="{left + PANEL / 2:.0f}" y="16" text-anchor="middle">{title}</text>')
        for tick in range(low, high + 1):
            label = f"{10.0**tick:g}" if logarithmic else str(tick)
            parts.append(
                f'<path d="M{x(tick):.1f} {TOP - 6}V{height - 26}" stroke="#ddd"/>'
                f'<text x="{x(tick):.1f}" y="{height - 10}" text-anchor="middle">{label}</text>'
            )
        for number, column in enumerate(columns):
            y = TOP + ROW * (number + 0.5)
            ends = [x(value) for value in column]
            fill = "#7fb3d9" if list(runs)[number].startswith("rover") else "#d9c27f"
            parts.append(
                f'<path d="M{ends[0]:.1f} {y}H{ends[4]:.1f}" stroke="#444"/>'
                f'<rect x="{ends[1]:.1f}" y="{y - 7}" width="{max(ends[3] - ends[1], 1):.1f}" height="14" '
                f'fill="{fill}" stroke="#444"/><path d="M{ends[2]:.1f} {y - 7}v14" stroke="#b00" stroke-width="2"/>'
            )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(parts) + "</svg>\n", encoding="utf-8")
