"""What `rover monitor` has seen, as a picture of four lanes or as a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rover.chart import Line, Page, Text, ticks
from rover.link.self_test import SENSORS
from rover.link.watching import Moment
from rover.whole_file import write_whole

WIDTH, LEFT, RIGHT, TOP, LANE, GAP = 900, 70, 130, 20, 120, 24
INK, FAINT = "#222222", "#c9ced3"
COLOURS = ("#1f5f99", "#c2410c", "#2f7d32", "#7a4fa3")

Curve = tuple[str, list[float | None]]


def write_plot(moments: Sequence[Moment], path: Path) -> None:
    """PNG, SVG or CSV by the file's ending. Raises OSError."""
    kind = path.suffix.lower()
    if kind == ".csv":
        write_whole(path, table(moments).encode())
    else:
        page = draw(moments)
        write_whole(path, page.png() if kind == ".png" else page.svg().encode())


def table(moments: Sequence[Moment]) -> str:
    """CSV with a header; faults are joined by blanks, the ranges have a column each."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    scalars = [name for name in Moment(0.0).as_dict() if name not in ("ranges_m", "sonars", "faults")]
    writer.writerow(
        [*scalars, *(f"range_{name}_m" for name in SENSORS), *(f"sonar_{name}" for name in SENSORS), "faults"]
    )
    for moment in moments:
        row = moment.as_dict()
        writer.writerow([*(row[name] for name in scalars), *moment.ranges_m, *moment.sonars, " ".join(moment.faults)])
    return text.getvalue()


def draw(moments: Sequence[Moment]) -> Page:
    """Speeds, duties, ranges and voltage over time."""
    lanes: list[tuple[str, list[Curve]]] = [
        (
            "speed m/s",
            [("wanted", [m.wanted_speed_m_s for m in moments]), ("measured", [m.speed_m_s for m in moments])],
        ),
        ("duty", [("left", [m.left_duty for m in moments]), ("right", [m.right_duty for m in moments])]),
        ("range m", [(name, [m.ranges_m[n] for m in moments]) for n, name in enumerate(SENSORS)]),
        ("battery V", [("battery", [m.battery_v for m in moments])]),
    ]
    page = Page(WIDTH, TOP + len(lanes) * (LANE + GAP) + 16)
    times = [moment.time_s for moment in moments]
    for number, (title, curves) in enumerate(lanes):
        _lane(page, TOP + number * (LANE + GAP), title, times, curves)
    return page


def _lane(page: Page, top: float, title: str, times: list[float], curves: list[Curve]) -> None:
    known = [value for _, values in curves for value in values if value is not None] or [0.0]
    margin = 0.05 * (max(known) - min(known)) or 0.1
    low, high = min(known) - margin, max(known) + margin
    begin, end = (times[0], max(times[-1], times[0] + 1e-6)) if times else (0.0, 1.0)
    page.rectangle(LEFT, top, WIDTH - LEFT - RIGHT, LANE, FAINT)
    page.marks.append(Text(14, top + LANE / 2, title, INK, 12.0, "middle", upright=True))

    def across(time: float) -> float:
        return LEFT + (time - begin) / (end - begin) * (WIDTH - LEFT - RIGHT)

    def down(value: float) -> float:
        return top + LANE - (value - low) / (high - low) * LANE

    for value in ticks(low, high, 5):
        if low <= value <= high:
            page.marks.append(Text(LEFT - 6, down(value) + 4, f"{value:g}", INK, 11.0, "end"))
    for time in ticks(begin, end, 8):
        if begin <= time <= end:
            page.marks.append(Text(across(time), top + LANE + 14, f"{time:g} s", INK, 11.0, "middle"))
    for (name, values), colour, place in zip(curves, COLOURS, range(len(curves)), strict=False):
        page.marks.append(Text(WIDTH - RIGHT + 8, top + 16 + 16 * place, name, colour))
        pieces: list[list[tuple[float, float]]] = [[]]
        for time, told in zip(times, values, strict=True):
            if told is None:
                pieces.append([])
            else:
                pieces[-1].append((across(time), down(told)))
        page.marks.extend(Line(np.array(piece), colour, 1.4) for piece in pieces if len(piece) > 1)
