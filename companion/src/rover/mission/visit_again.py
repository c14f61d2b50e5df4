"""From the folder of a run to the earlier visit that a second one is fused with."""

from __future__ import annotations

import json
from pathlib import Path

from rover.errors import BadInput
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.earlier_visit import EarlierVisit, plain
from rover.mission.former_run import SURVEY, WHAT, FormerRun
from rover.mission.perception import Perception


def earlier_visit(former: FormerRun, perception: Perception) -> EarlierVisit:
    """What a run has left, for a visit over the same area. Raises BadInput."""
    if not former.keyframes.frames:
        raise BadInput(f"{former.folder}: that run has seen nothing")
    if former.hour is None:
        raise BadInput(f"{former.folder}: left by an older version, which did not write down its hour")
    width, height = (side * perception.grid.resolution for side in perception.grid.shape[::-1])
    grid = SurveyGrid(width, height, perception.grid.resolution)
    try:
        grid.restore(former.layers, former.keyframes.submap_poses)
    except ValueError:
        raise BadInput(f"{former.folder / SURVEY}: damaged {WHAT}") from None
    name = former.folder.resolve().name
    return EarlierVisit(name, former.hour, former.keyframes, plain(grid), tuple(former.places))


def check_same_field(folder: Path, seed: int) -> None:
    """Of simulated rigs: raises BadInput where the run in `folder` was not driven in the field of `seed`."""
    truth = folder / "truth.json"
    try:
        driven = json.loads(truth.read_text(encoding="utf-8"))["seed"]
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInput(f"{truth}: not there, or damaged: on this rig only a simulated run is surveyed after") from None
    if driven != seed:
        raise BadInput(f"{folder}: driven with --seed {driven}, a field other than that of --seed {seed}")
