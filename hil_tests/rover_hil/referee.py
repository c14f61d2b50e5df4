"""Judges a finished run by the truth alone: keep-out zones, mines driven over, and what was reported of the mines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover.geometry import Pose2, wrap_angle
from rover.vehicle import STANDARD

from rover_hil.ground import Mine

Array = NDArray[np.float64]

# Wheels stand this far left and right of base_link.
WHEEL_OFFSET_M = 0.5 * STANDARD.track_width

# Contact patch of a wheel: length along the rover and width across, metres; the plant uses the same.
PATCH_M = (0.06, 0.025)

# Seconds that the rover has to stop once a zone is declared.
GRACE_S = 0.5

# A wheel that was inside at the declaration may wander this much deeper while it leaves, metres.
MIN_DEEPER_M = 0.01

# A mine counts as reported when an indication lies this close, metres.
FOUND_WITHIN_M = 0.10

# Mines with at least this contrast are the ones that a thermal camera is expected to find.
FAIR_CONTRAST_K = 0.5

NOT_A_MINE = ("obstacle", "background")


def wheel_distance(truth: Array, x: float, y: float) -> Array:
    """Distance (n,) from a point to the nearer wheel's contact patch along the trajectory (n, 4); 0 under a wheel."""
    dx, dy = x - truth[:, 1], y - truth[:, 2]
    cosine, sine = np.cos(truth[:, 3]), np.sin(truth[:, 3])
    along, across = cosine * dx + sine * dy, cosine * dy - sine * dx
    ahead = np.maximum(np.abs(along) - 0.5 * PATCH_M[0], 0.0)
    # Both wheels at once: the nearer one is on the point's side.
    aside = np.maximum(np.abs(np.abs(across) - WHEEL_OFFSET_M) - 0.5 * PATCH_M[1], 0.0)
    return np.hypot(ahead, aside)


def on_ground(truth: Array, thing: dict[str, Any]) -> dict[str, Any]:
    """A zone or an indication where it really lies: as seen from where the rover really was when it saw it.

    `thing` has x, y in the companion's map and may have an "anchor": when the rover saw it ("t") and where it believed
    to be then ("x", "y", "heading"). The map as a whole may be off, and may bend later; the ground that was seen does
    not. Without an anchor the map is taken for true.
    """
    anchor = thing.get("anchor")
    if anchor is None or not len(truth):
        return thing
    believed = Pose2(float(anchor["x"]), float(anchor["y"]), float(anchor["heading"]))
    real = _pose_at(truth, float(anchor["t"]))
    place = np.array([[float(thing["x"]), float(thing["y"])]])
    x, y = real.transform(believed.inverse().transform(place))[0].tolist()
    return {**thing, "x": x, "y": y}


def _pose_at(truth: Array, time: float) -> Pose2:
    """The true pose at a time, from the samples before and after it."""
    after = int(np.clip(np.searchsorted(truth[:, 0], time), 1, max(len(truth) - 1, 1)))
    (t0, x0, y0, h0), (t1, x1, y1, h1) = truth[after - 1].tolist(), truth[min(after, len(truth) - 1)].tolist()
    share = min(max((time - t0) / (t1 - t0), 0.0), 1.0) if t1 > t0 else 0.0
    return Pose2(x0 + share * (x1 - x0), y0 + share * (y1 - y0), h0 + share * wrap_angle(h1 - h0))


def judge_place(truth: Array, versions: Sequence[dict[str, Any]]) -> tuple[int, bool]:
    """How often a wheel came into a zone, and whether the zone was declared under a wheel.

    A stay in the zone counts once a wheel stands on ground that the zone has covered for GRACE_S, redrawn or not. A
    stay that begins because the zone was drawn under a wheel does not count while the wheel goes no deeper.
    """
    times = truth[:, 0]
    starts = np.array([float(version["t"]) for version in versions])
    ends = np.array([math.inf if version.get("until") is None else float(version["until"]) for version in versions])
    distances = np.array([wheel_distance(truth, float(v["x"]), float(v["y"])) for v in versions])
    within = distances < np.array([float(version["r"]) for version in versions])[:, None]
    alive = (starts[:, None] <= times) & (times <= ends[:, None])
    lately = (starts[:, None] <= times) & (times - GRACE_S <= ends[:, None])
    ripe = (starts[:, None] < times - GRACE_S) & (times - GRACE_S <= ends[:, None])
    covered = np.all(within | ~lately, axis=0) & np.any(ripe, axis=0)
    current = np.where(np.any(alive, axis=0), len(versions) - 1 - np.argmax(alive[::-1], axis=0), -1)
    inside = (current >= 0) & np.take_along_axis(within, np.maximum(current, 0)[None, :], axis=0)[0]

    entries, under = 0, False
    for first, last in _runs(inside):
        drawn_there = bool(first == 0 or current[first] != current[first - 1])
        under |= drawn_there
        leaving = drawn_there and not _goes_deeper(distances, current, first, last)
        entries += bool(covered[first:last].any()) and not leaving
    return entries, under


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First index and the one behind the last of every run of True."""
    edges = np.diff(flags.astype(np.int8), prepend=0, append=0)
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True))


def _goes_deeper(distances: Array, current: NDArray[np.int64], first: int, last: int) -> bool:
    """Whether a wheel comes nearer to the zone's centre than it was when that version was drawn."""
    for version in np.unique(current[first:last]).tolist():
        track = distances[version, first:last][current[first:last] == version]
        if track.min() < track[0] - MIN_DEEPER_M:
            return True
    return False


def judge_zones(truth: Array, zones: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """keepout_violations, the zones that they happened in, and zones_declared_under_wheel.

    Zones are {"t", "id", "x", "y", "r"} in seconds and metres, with "until" when they ended and the "anchor" of
    `on_ground`; one that was redrawn comes again with the same id.
    """
    violated, under_wheel, total = [], [], 0
    zones = [on_ground(truth, zone) for zone in zones]
    for identifier in sorted({zone["id"] for zone in zones}):
        versions = [zone for zone in zones if zone["id"] == identifier]
        entries, under = judge_place(truth, sorted(versions, key=lambda version: float(version["t"])))
        total += entries
        if entries:
            violated.append(identifier)
        if under:
            under_wheel.append(identifier)
    return {
        "keepout_violations": total,
        "zones_violated": violated,
        "zones_declared_under_wheel": under_wheel,
    }


def judge_mines(
    truth: Array, mines: Sequence[Mine], detections: Sequence[dict[str, Any]], area: float
) -> dict[str, Any]:
    """Mines driven over, mines reported, and indications where no mine is; `area` in m².

    Detections are {"class", "x", "y"} with the "anchor" of `on_ground`.
    """
    reported = [on_ground(truth, d) for d in detections if d.get("class") not in NOT_A_MINE]
    places = [(float(d["x"]), float(d["y"])) for d in reported]
    rows: list[dict[str, Any]] = []
    for mine in mines:
        errors = [math.hypot(x - mine.x, y - mine.y) for x, y in places]
        nearest = min(errors, default=math.inf)
        rows.append(
            {
                "id": mine.id,
                "contrast_k": mine.contrast_k,
                "found": nearest <= FOUND_WITHIN_M,
                "error_m": nearest if math.isfinite(nearest) else None,
                "driven_over": bool((wheel_distance(truth, mine.x, mine.y) < mine.radius).any()),
            }
        )
    false = sum(all(math.hypot(x - m.x, y - m.y) > FOUND_WITHIN_M for m in mines) for x, y in places)
    fair = [row for row in rows if abs(row["contrast_k"]) >= FAIR_CONTRAST_K]
    return {
        "wheel_over_mine": sum(row["driven_over"] for row in rows),
        "mines": rows,
        "mines_with_contrast": len(fair),
        "mines_with_contrast_found": sum(row["found"] for row in fair),
        "false_indications": false,
        "false_indications_per_m2": false / area,
    }
