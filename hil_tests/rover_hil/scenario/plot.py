"""One run as inline SVG: command and speed, way, duty, the firmware's state, and what happened, around the fault."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rover.report.markup import Html, join, text

from rover_hil.scenario.observation import Moment, Track

WIDTH, LEFT, RIGHT = 900, 64, 12
LANE, GAP, BAND, TOP = 92, 14, 22, 6
BEFORE, AFTER = 1.0, 0.6
"""Seconds shown before the first fault and after the last event."""

COMMAND, TRUTH, FAULT, FAINT = "#1f5f99", "#c2410c", "#b3161d", "#5d656c"
STATE_COLOURS = {
    "Boot": "#d9dde0",
    "Disarmed": "#e8eaec",
    "Armed": "#bcd4ea",
    "Moving": "#7fb0da",
    "Stopping": "#f2c96d",
    "Latched": "#e58e8e",
}


@dataclass(frozen=True)
class Curve:
    """A value over time. `name` None: it needs no legend."""

    name: str | None
    colour: str
    value: Callable[[Moment], float]


@dataclass(frozen=True)
class Lane:
    """One diagram; its scale begins at zero and ends no lower than `least`."""

    title: str
    unit: str
    least: float
    curves: tuple[Curve, ...]


def _number(key: str, absolute: bool = False) -> Callable[[Moment], float]:
    def value(moment: Moment) -> float:
        number = float(moment.values.get(key, 0.0))
        return abs(number) if absolute else number

    return value


LANES = (
    Lane(
        "speed",
        "m/s",
        0.3,
        (
            Curve("commanded", COMMAND, _number("commanded_speed", absolute=True)),
            Curve("true", TRUTH, _number("speed")),
        ),
    ),
    Lane(
        "turn rate",
        "rad/s",
        0.3,
        (
            Curve("commanded", COMMAND, _number("commanded_turn_rate", absolute=True)),
            Curve("true", TRUTH, _number("turn_rate")),
        ),
    ),
    Lane("way", "m", 0.1, (Curve(None, TRUTH, _number("travelled_m")),)),
    Lane("duty", "", 1.0, (Curve(None, TRUTH, _number("duty")),)),
)


def plot(track: Track, title: str) -> Html:
    """The picture as one `svg` element, without anything from outside."""
    begin, end = _window(track)
    moments = [moment for moment in track.moments if begin <= moment.time <= end]
    scale = Scale(begin, max(end, begin + 0.01))
    parts: list[str] = []
    y = float(TOP)
    for lane in LANES:
        parts.append(_lane(lane, moments, scale, y))
        y += LANE + GAP
    parts.append(_states(moments, scale, y))
    y += BAND + GAP
    parts.append(_axis(scale, y))
    parts.append(_faults(track, scale, y))
    height = round(y + 26)
    label = text(f"{title}: speed, turn rate, way, duty and state over time")
    return Html(
        f'<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}" font-size="12">'
        f"{join([Html(part) for part in parts])}</svg>"
    )


@dataclass(frozen=True)
class Scale:
    """Time in seconds to columns."""

    begin: float
    end: float

    def x(self, time: float) -> float:
        """Column of a time."""
        return LEFT + (time - self.begin) / (self.end - self.begin) * (WIDTH - LEFT - RIGHT)


def _window(track: Track) -> tuple[float, float]:
    faults = [time for time, what in track.events if what.startswith("fault: ")]
    begin = max(0.0, (faults[0] if faults else 0.0) - BEFORE)
    end = min(track.last.time, max((time for time, _ in track.events), default=0.0) + AFTER)
    return begin, end


def _lane(lane: Lane, moments: Sequence[Moment], scale: Scale, top: float) -> str:
    highest = max([lane.least, *(curve.value(m) for curve in lane.curves for m in moments)])
    bottom = top + LANE

    def y(value: float) -> float:
        return bottom - value / highest * LANE

    parts = [
        f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{bottom:.1f}" y2="{bottom:.1f}" stroke="#d9dde0"/>',
        _label(LEFT - 6, top + 10, f"{highest:.2g} {lane.unit}".strip(), "end"),
        _label(LEFT - 6, bottom, "0", "end"),
        _label(LEFT - 6, 0.5 * (top + bottom) + 4, lane.title, "end"),
    ]
    for number, curve in enumerate(lane.curves):
        points = " ".join(f"{scale.x(m.time):.1f},{y(curve.value(m)):.1f}" for m in moments)
        parts.append(f'<polyline points="{points}" fill="none" stroke="{curve.colour}" stroke-width="1.6"/>')
        if curve.name:
            parts.append(_label(LEFT + 8 + 90 * number, top + 10, curve.name, "start", curve.colour))
    return "".join(parts)


def _states(moments: Sequence[Moment], scale: Scale, top: float) -> str:
    parts = [_label(LEFT - 6, top + 15, "state", "end")]
    for state, group in itertools.groupby(moments, key=lambda moment: str(moment.values["state"])):
        members = list(group)
        left, right = scale.x(members[0].time), scale.x(members[-1].time)
        width = max(right - left, 1.0)
        colour = STATE_COLOURS.get(state, "#ffffff")
        parts.append(
            f'<rect x="{left:.1f}" y="{top}" width="{width:.1f}" height="{BAND}" fill="{colour}">'
            f"<title>{text(state)}, {members[0].time:.3f} to {members[-1].time:.3f} s</title></rect>"
        )
        if width > 7 * len(state):
            parts.append(_label(left + 4, top + 15, state, "start", "#22262a"))
    return "".join(parts)


def _axis(scale: Scale, y: float) -> str:
    step = next(step for step in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 1e9) if (scale.end - scale.begin) / step <= 12)
    parts = []
    tick = -(-scale.begin // step)
    while tick * step <= scale.end:
        x = scale.x(tick * step)
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{y - 4:.1f}" y2="{y:.1f}" stroke="{FAINT}"/>')
        parts.append(_label(x, y + 14, f"{tick * step:g} s", "middle"))
        tick += 1
    return "".join(parts)


def _faults(track: Track, scale: Scale, bottom: float) -> str:
    parts = []
    for time, what in track.events:
        if not scale.begin <= time <= scale.end or what.startswith("firmware: fault"):
            continue
        colour = FAULT if what.startswith("fault: ") else FAINT
        dash = "" if what.startswith("fault: ") else ' stroke-dasharray="2 4"'
        x = scale.x(time)
        parts.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{bottom:.1f}" stroke="{colour}"{dash}>'
            f"<title>{time:.3f} s {text(what)}</title></line>"
        )
    return "".join(parts)


def _label(x: float, y: float, content: str, anchor: str, colour: str = FAINT) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{text(content)}</text>'
