"""What a run has learned of its field, kept in its folder, so that a next one goes on from there.

`keyframes.npz` tells the next run where it is (`rover.vision.localization.keyframe_map`), `survey.npz` what is known
already: seen ground, obstacles, places with all their evidence, goals. Nothing is taken over but what lies in the same
area.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rover.archive_file import UNREADABLE, damaged, pack_archive, read_archive
from rover.detection.place import Place
from rover.errors import BadInput
from rover.mission.config import Mission
from rover.mission.goals import Goal, GoalState
from rover.vision.camera.model import CameraModel
from rover.vision.localization.keyframe_map import FILE_NAME as KEYFRAMES
from rover.vision.localization.keyframe_map import KeyframeMap, load_map, map_arrays

if TYPE_CHECKING:
    from rover.mission.survey import Survey

SURVEY = "survey.npz"
WHAT = "survey"
VERSION = 3
# In version 2 every layer of a submap covered its whole window.
READABLE = (2, 3)
FILES = (KEYFRAMES, SURVEY)


@dataclass(frozen=True, eq=False)
class FormerRun:
    """layers: of the map, by name. looks: how often each cell was looked for. next_place: number of the next new one.

    released: places that were inspected and proved to be no indication. hour: of its day, 0 to 24; None where the
    file, of an older version, does not say.
    """

    folder: Path
    keyframes: KeyframeMap
    layers: dict[str, NDArray[Any]]
    looks: NDArray[np.uint8]
    places: list[Place]
    next_place: int
    goals: list[Goal]
    released: set[int]
    hour: float | None = None


@dataclass(frozen=True, eq=False)
class Learned:
    """What a run has learned so far: of the ground around the rover a copy, of all else what does not change now."""

    known: KeyframeMap
    camera: CameraModel
    arrays: dict[str, NDArray[Any]]

    def packed(self) -> dict[str, bytes]:
        """Content of both files by name. The same run gives the same bytes."""
        return {KEYFRAMES: pack_archive(map_arrays(self.known, self.camera)), SURVEY: pack_archive(self.arrays)}


def learned(survey: Survey) -> Learned | None:
    """What a run has learned so far; None where nothing was seen. Costs little, however large the field."""
    perception = survey.perception
    known = perception.localizer.map
    if not known.frames:
        return None
    content = {
        "version": VERSION,
        "area": [survey.mission.area.width, survey.mission.area.height],
        "hour": survey.mission.time_of_day_s / 3600.0,
        "next_place": perception.evidence.next_place,
        "places": [_record(place) for place in perception.evidence.places],
        "goals": [asdict(goal) for goal in survey.goals],
        "released": sorted(perception.released),
    }
    arrays = {f"layer_{name}": layer for name, layer in perception.grid.layers().items()}
    arrays["looks"] = survey.coverage.looks.copy()
    arrays["content"] = np.frombuffer(json.dumps(content).encode(), np.uint8)
    return Learned(known, perception.camera, arrays)


def can_go_on_from(folder: Path) -> bool:
    """True when the folder holds what a next run goes on from."""
    return all((folder / name).is_file() for name in FILES)


def load_run(folder: Path, mission: Mission, camera: CameraModel) -> FormerRun:
    """What a run left in its folder.

    Raises BadInput, one line, for a folder that holds no such files, damaged ones, or those of another area or camera.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder; the folder of an earlier run is expected")
    keyframes = load_map(folder, camera)
    path = folder / SURVEY
    arrays = read_archive(path, WHAT)
    try:
        content = json.loads(arrays["content"].tobytes())
        if content["version"] not in READABLE:
            raise BadInput(f"{path}: survey of version {content['version']}; this rover reads version {VERSION}")
        width, height = (float(side) for side in content["area"])
        if (width, height) != (mission.area.width, mission.area.height):
            raise BadInput(
                f"{path}: of an area of {width:g} × {height:g} m; that of {mission.path} has "
                f"{mission.area.width:g} × {mission.area.height:g} m"
            )
        layers = {name.removeprefix("layer_"): layer for name, layer in arrays.items() if name.startswith("layer_")}
        return FormerRun(
            folder,
            keyframes,
            layers,
            arrays["looks"].astype(np.uint8),
            [_place(record) for record in content["places"]],
            int(content["next_place"]),
            [_goal(record) for record in content["goals"]],
            {int(number) for number in content["released"]},
            None if content.get("hour") is None else _finite(content["hour"]),
        )
    except BadInput:
        raise
    except UNREADABLE as error:
        raise damaged(path, WHAT) from error


def go_on_from(former: FormerRun, survey: Survey) -> None:
    """Puts it into a survey that has not begun; the survey's localizer must have been given the keyframes.

    What was given up is tried again; the operator's goals are those of the mission file.
    """
    perception = survey.perception
    try:
        perception.grid.restore(former.layers, former.keyframes.submap_poses)
        survey.coverage.restore(former.looks)
    except ValueError as error:
        raise damaged(former.folder / SURVEY, WHAT) from error
    perception.evidence.restore(former.places, former.next_place)
    perception.released |= former.released
    survey.goals.restore(former.goals)
    shown = 1.0 - float(survey.coverage.unshown().mean())
    known = f"{shown:.0%} of the area and {len(former.places)} places"
    survey.timeline.append((0.0, f"going on from an earlier run: {known} known already"))


def _record(place: Place) -> dict[str, Any]:
    """A place as JSON values."""
    content = asdict(place)
    del content["anchor"]  # of a time of the run before
    for name, value in content.items():
        if isinstance(value, np.ndarray):
            content[name] = value.tolist()
    content["_seen_from"] = [[*view, count] for view, count in place._seen_from.items()]
    return content


def _place(record: dict[str, Any]) -> Place:
    """The place again; seen before the run began."""
    return Place(
        id=int(record["id"]),
        x=_finite(record["x"]),
        y=_finite(record["y"]),
        first_seen=0.0,
        last_seen=0.0,
        sigma_m=_finite(record["sigma_m"]),
        p={str(name): _finite(value) for name, value in record["p"].items()},
        views=int(record["views"]),
        extent=_finite(record["extent"]),
        suspected=bool(record["suspected"]),
        indication=bool(record["indication"]),
        looks=int(record["looks"]),
        earlier=_probabilities(record.get("earlier")),
        together=None if record.get("together") is None else _finite(record["together"]),
        submap=int(record["submap"]),
        _evidence=_finite_array(record["_evidence"]),
        _weight=_finite(record["_weight"]),
        _seen_from={(int(a), int(b), int(c)): int(count) for a, b, c, count in record["_seen_from"]},
        _sums=_finite_array(record["_sums"]),
        _pose_variance=float(record["_pose_variance"]),  # infinite until the place has been seen
    )


def _probabilities(value: Any) -> dict[str, float] | None:
    return None if value is None else {str(name): _finite(p) for name, p in value.items()}


def _goal(record: dict[str, Any]) -> Goal:
    return Goal(
        id=str(record["id"]),
        x=_finite(record["x"]),
        y=_finite(record["y"]),
        place_id=None if record["place_id"] is None else int(record["place_id"]),
        state=GoalState(record["state"]),
        reason=str(record["reason"]),
        attempts=int(record["attempts"]),
        inspected_at=None if record["inspected_at"] is None else _finite(record["inspected_at"]),
    )


def _finite(value: Any) -> float:
    """A place that is not a number would be lost to every comparison: no survey with one is gone on from."""
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{value} is no number")
    return number


def _finite_array(values: Any) -> NDArray[np.float64]:
    return np.array([_finite(value) for value in values], dtype=np.float64)
