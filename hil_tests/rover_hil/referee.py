"""Judges a finished run by the truth alone: keep-out zones, mines driven over, and what was reported of the mines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WHEEL_OFFSET = 0.10
"""Wheels stand this far left and right of base_link, metres."""

PATCH = (0.06, 0.025)
"""Contact patch of a wheel: length along the rover and width across, metres; the plant uses the same."""

GRACE = 0.5
"""Seconds that the rover has to stop once a zone is declared."""

DEEPER = 0.01
"""A wheel that was inside at the declaration may wander this much deeper while it leaves, metres."""

FOUND_WITHIN = 0.10
"""A mine counts as reported when an indication lies this close, metres."""

FAIR_CONTRAST_K = 0.5
"""Mines with at least this contrast are the ones that a thermal camera is expected to find."""

NOT_A_MINE = ("obstacle", "background")


class Mine(Protocol):
    """What lies in the ground (`rover_hil.ground.Mine`)."""

    id: int
    x: float
    y: float
    radius: float
    contrast_k: float


def wheel_distance(truth: Array, x: float, y: float) -> Array:
    """Distance (n,) from a point to the nearer wheel's contact patch along the trajectory (n, 4); 0 under a wheel."""
    dx, dy = x - truth[:, 1], y - truth[:, 2]
    cosine, sine = np.cos(truth[:, 3]), np.sin(truth[:, 3])
    along, across = cosine * dx + sine * dy, cosine * dy - sine * dx
    ahead = np.maximum(np.abs(along) - 0.5 * PATCH[0], 0.0)
    # Both wheels at once: the nearer one is on the point's side.
    aside = np.maximum(np.abs(np.abs(across) - WHEEL_OFFSET) - 0.5 * PATCH[1], 0.0)
    return np.hypot(ahead, aside)


def judge_zone(truth: Array, zone: dict[str, Any]) -> tuple[int, bool]:
    """How often a wheel came into the zone, and whether one stood in it when the zone was declared.

    The zone counts from `t` + GRACE until `until` (if given). A wheel that was inside at the declaration may leave
    without being counted as long as it does not go deeper.
    """
    declared, end = float(zone["t"]), zone.get("until")
    alive = truth[:, 0] >= declared
    if end is not None:
        alive &= truth[:, 0] <= float(end)
    track = truth[alive]
    if not len(track):
        return 0, False
    distance = wheel_distance(track, float(zone["x"]), float(zone["y"]))
    inside = distance < float(zone["r"])
    counted = inside & (track[:, 0] > declared + GRACE)
    under = bool(inside[0])
    if under:
        left = int(np.argmin(inside)) if not inside.all() else len(inside)
        if distance[:left].min() >= distance[0] - DEEPER:
            counted[:left] = False
    entries = int(counted[0]) + int(np.count_nonzero(np.diff(counted.astype(np.int8)) == 1))
    return entries, under


def judge_zones(truth: Array, zones: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """keepout_violations, the zones that they happened in, and zones_declared_under_wheel."""
    violated, under_wheel, total = [], [], 0
    for zone in zones:
        entries, under = judge_zone(truth, zone)
        total += entries
        if entries:
            violated.append(zone["id"])
        if under:
            under_wheel.append(zone["id"])
    return {
        "keepout_violations": total,
        "zones_violated": violated,
        "zones_declared_under_wheel": under_wheel,
    }


def judge_mines(
    truth: Array, mines: Sequence[Mine], detections: Sequence[dict[str, Any]], area: float
) -> dict[str, Any]:
    """Mines driven over, mines reported, and indications where no mine is; `area` in m²."""
    places = [(float(d["x"]), float(d["y"])) for d in detections if d.get("class") not in NOT_A_MINE]
    rows = []
    for mine in mines:
        errors = [math.hypot(x - mine.x, y - mine.y) for x, y in places]
        nearest = min(errors, default=math.inf)
        rows.append(
            {
                "id": mine.id,
                "contrast_k": mine.contrast_k,
                "found": nearest <= FOUND_WITHIN,
                "error_m": nearest if math.isfinite(nearest) else None,
                "driven_over": bool((wheel_distance(truth, mine.x, mine.y) < mine.radius).any()),
            }
        )
    false = sum(all(math.hypot(x - m.x, y - m.y) > FOUND_WITHIN for m in mines) for x, y in places)
    fair = [row for row in rows if abs(row["contrast_k"]) >= FAIR_CONTRAST_K]
    return {
        "wheel_over_mine": sum(row["driven_over"] for row in rows),
        "mines": rows,
        "mines_with_contrast": len(fair),
        "mines_with_contrast_found": sum(row["found"] for row in fair),
        "false_indications": false,
        "false_indications_per_m2": false / area,
    }
