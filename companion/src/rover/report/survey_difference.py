"""What differs between two surveys of one field: indications that are new, gone, moved, or in both.

An indication that only one survey has means little where the other did not look: each of these says whether it did.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.mapping.map_server import StoredMap, read
from rover.plain_file import plain_file
from rover.report.geojson import projection
from rover.report.site import Georeference

# Two surveys begin at launches that somebody set down by hand: their maps agree no better than this, metres (1 sigma).
LAUNCH_SIGMA = 0.03
# Beyond so many sigma two places are not the same one, within so many metres they may be one that has moved.
SAME_SIGMAS = 3.0
MOVED_M = 0.5

Point = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Survey:
    """What a run says of a field: its indications as in summary.json, its map (None: not there), its place on earth."""

    name: str
    detections: tuple[dict[str, Any], ...]
    ground: StoredMap | None
    origin: Georeference | None

    def saw(self, at: Point) -> bool | None:
        """Whether the ground there was seen; None where nobody knows."""
        if self.ground is None:
            return None
        column = math.floor((at[0] - self.ground.origin[0]) / self.ground.resolution)
        row = math.floor((at[1] - self.ground.origin[1]) / self.ground.resolution)
        rows, columns = self.ground.seen.shape
        return 0 <= row < rows and 0 <= column < columns and bool(self.ground.seen[row, column])


def read_survey(folder: Path) -> Survey:
    """A run's folder. Raises BadInput."""
    file = folder / "summary.json"
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder of a run")
    try:
        summary = json.loads(plain_file(file).read_bytes())
        detections = tuple(_detection(entry) for entry in summary["detections"])
        site = summary.get("site") or {}
        origin = None
        if site.get("origin") is not None:
            latitude, longitude = site["origin"]
            origin = Georeference(float(latitude), float(longitude), float(site["bearing_deg"]))
    except FileNotFoundError:
        why = "the run has not come to its end; see rover recover"
        raise BadInput(f"{folder}: no summary.json is there: {why}") from None
    except OSError as error:
        raise BadInput(f"{file}: cannot be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise BadInput(f"{file}: damaged: not the summary of a run") from None
    ground = read(folder / "map.yaml") if (folder / "map.yaml").is_file() else None
    return Survey(folder.name, detections, ground, origin)


def difference(before: Survey, after: Survey) -> dict[str, Any]:
    """The document of `rover compare`; distances in metres, places each in their own survey's map."""
    to_after, to_before = _between(before.origin, after.origin), _between(after.origin, before.origin)
    there = [to_after((entry["x"], entry["y"])) for entry in before.detections]
    here = [(entry["x"], entry["y"]) for entry in after.detections]
    distances = [[math.dist(a, b) for b in here] for a in there]

    def same(i: int, j: int) -> bool:
        sigma = math.hypot(before.detections[i]["sigma_m"], after.detections[j]["sigma_m"], LAUNCH_SIGMA)
        return distances[i][j] <= SAME_SIGMAS * sigma

    def moved(i: int, j: int) -> bool:
        alike = before.detections[i]["class"] == after.detections[j]["class"]
        return alike and distances[i][j] <= MOVED_M

    both = _pairs(distances, same, set(), set())
    shifted = _pairs(distances, moved, {i for i, _ in both}, {j for _, j in both})
    matched = both + shifted
    gone = [i for i in range(len(there)) if all(i != known for known, _ in matched)]
    new = [j for j in range(len(here)) if all(j != known for _, known in matched)]

    def pair(i: int, j: int) -> dict[str, Any]:
        return {
            "before": before.detections[i],
            "after": after.detections[j],
            "distance_m": round(distances[i][j], 4),
        }

    return {
        "before": before.name,
        "after": after.name,
        "frame": "WGS 84" if before.origin is not None and after.origin is not None else "local, of the same launch",
        "new": [{**after.detections[j], "surveyed_before": before.saw(to_before(here[j]))} for j in new],
        "gone": [{**before.detections[i], "surveyed_after": after.saw(there[i])} for i in gone],
        "moved": [pair(i, j) for i, j in shifted],
        "both": [pair(i, j) for i, j in both],
    }


def _pairs(
    distances: Sequence[Sequence[float]], fits: Callable[[int, int], bool], used_i: set[int], used_j: set[int]
) -> list[tuple[int, int]]:
    """Pairs that fit, the nearest first, each place in one pair at most; in the order of the first survey."""
    candidates = sorted(
        (distance, i, j)
        for i, row in enumerate(distances)
        for j, distance in enumerate(row)
        if i not in used_i and j not in used_j and fits(i, j)
    )
    taken: dict[int, int] = {}
    for _, i, j in candidates:
        if i not in taken and j not in taken.values():
            taken[i] = j
    return sorted(taken.items())


def _between(source: Georeference | None, target: Georeference | None) -> Callable[[Point], Point]:
    """From one survey's map into another's: over the earth where both have an origin, else they have the same map."""
    if source is None or target is None or source == target:
        return lambda point: point
    # Both maps are planes that touch the earth near each other: three points say how one lies in the other.
    place, at = projection(source, digits=14), projection(target, digits=14)
    east, north = (_inverse(at, place(*corner)) for corner in ((1.0, 0.0), (0.0, 1.0)))
    zero = _inverse(at, place(0.0, 0.0))

    def move(point: Point) -> Point:
        x, y = point
        return (
            zero[0] + x * (east[0] - zero[0]) + y * (north[0] - zero[0]),
            zero[1] + x * (east[1] - zero[1]) + y * (north[1] - zero[1]),
        )

    return move


def _inverse(project: Callable[[float, float], list[float]], place: Sequence[float]) -> Point:
    """Map x, y of a place in degrees: `project` is a linear map."""
    zero, along_x, along_y = project(0.0, 0.0), project(1.0, 0.0), project(0.0, 1.0)
    a, c = along_x[0] - zero[0], along_x[1] - zero[1]
    b, d = along_y[0] - zero[0], along_y[1] - zero[1]
    u, v = place[0] - zero[0], place[1] - zero[1]
    determinant = a * d - b * c
    return (d * u - b * v) / determinant, (a * v - c * u) / determinant


def _detection(entry: dict[str, Any]) -> dict[str, Any]:
    numbers = {name: float(entry[name]) for name in ("p", "x", "y", "sigma_m")}
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError(f"an indication at {numbers}")
    return {"id": int(entry["id"]), "class": str(entry["class"]), **numbers}
