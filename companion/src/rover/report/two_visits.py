"""The report's section on two visits: both maps, their difference, and what each found."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.report.map_plot import png_bytes
from rover.report.markup import NOTHING, Html, join, paragraph, picture, section, table, tag, text
from rover.report.palette import ZONE, false_colour, temperature_span
from rover.report.result import RunResult
from rover.report.visits import PlaceVisits

SIDE_PX = 380


def two_visits(result: RunResult) -> Html:
    """Nothing where there was one visit."""
    visits = result.visits
    if visits is None:
        return NOTHING
    hours = tuple(f"{int(hour):02d}:{round(60.0 * (hour % 1.0)):02d}" for hour in visits.hours)
    named = (
        (visits.first, f"first visit, {hours[0]}"),
        (visits.second, f"second visit, {hours[1]}"),
        (visits.difference, "second less first, without what all ground has in common"),
    )
    maps = [
        tag("figure", join((picture(png_bytes(_drawn(result, raster)), name, "visit"), tag("figcaption", text(name)))))
        for raster, name in named
    ]
    x, y, heading = visits.shift
    how = (
        f"The first visit, {visits.earlier}, is laid on this one by {visits.registered_by}"
        f"{f' ({visits.matches} matches)' if visits.matches else ''}: moved by {100.0 * x:.1f} and {100.0 * y:.1f} cm, "
        f"turned by {heading:.2f}°. Their structure correlates by {visits.agreement:.2f}; below zero what was warm is "
        "cold now. Nothing that either visit has reported is dropped."
    )
    head = ("Id", "Found by", "Mine, first", "Mine, second", "Mine, together", "Contrast", "Thermal inertia")
    rows = [(tag("span", text(number), "id"), *_row(place)) for number, place in sorted(visits.places.items())]
    note = paragraph(
        "Probabilities of a mine by each visit and by the temperatures of both; a dash where that visit did not report "
        "one. Contrast to the ground around at each visit, kelvin. Thermal inertia: apparent, as a share of that of "
        "the ground around; above a mine it is lower than one.",
        "faint",
    )
    told = (table(head, rows, (2, 3, 4, 5, 6)), note) if rows else (paragraph("Neither has reported anything."),)
    return section("Two visits", "visits", paragraph(how), tag("div", join(maps), "visits"), *told)


def _row(place: PlaceVisits) -> tuple[Html, ...]:
    first, second = ("–" if not math.isfinite(value) else f"{value:+.2f}" for value in place.contrast)
    return (
        text(place.found_by),
        text(_percent(place.first)),
        text(_percent(place.second)),
        text(_percent(place.together)),
        text(f"{first}, {second}"),
        text("–" if place.inertia is None else f"{place.inertia:.2f}"),
    )


def _percent(p: float | None) -> str:
    return "–" if p is None else f"{100.0 * p:.0f} %"


def _drawn(result: RunResult, kelvin: NDArray[np.float32]) -> NDArray[np.uint8]:
    """The raster as false colours with a ring around each indication, y up, BGR."""
    scale = SIDE_PX / max(kelvin.shape)
    coloured = false_colour(kelvin, temperature_span(kelvin))[::-1]
    size = round(kelvin.shape[1] * scale), round(kelvin.shape[0] * scale)
    image = np.ascontiguousarray(cv2.resize(coloured, size, interpolation=cv2.INTER_AREA))
    cells = scale / result.layers.resolution
    for detection in result.detections:
        at = round(detection.x * cells), round(size[1] - detection.y * cells)
        cv2.circle(image, at, max(3, round(0.12 * cells)), ZONE, 1, cv2.LINE_AA)
    return np.asarray(image, np.uint8)
