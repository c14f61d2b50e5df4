"""However early a mission ends, it has a result and a report."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path

import pytest
from rover.detection.classifier import Classifier, default_model
from rover.geometry import Pose2
from rover.link.statistics import LinkFigures
from rover.mission.assemble import assemble
from rover.mission.begin import begin
from rover.mission.config import load
from rover.mission.origin import identities_of
from rover.mission.outputs import write_outputs
from rover.mission.track import Track
from rover.outcome import Outcome, RunStatus
from rover.vision.camera.file import load_camera


@pytest.mark.parametrize("poses", [0, 1, 2])
def test_a_mission_that_ends_before_it_knew_where_it_is_has_a_report(tmp_path: Path, poses: int) -> None:
    mission = load("demo")
    classifier = Classifier(default_model())
    survey = begin(mission, load_camera(mission.rover.camera), classifier, 1, None)
    survey.outcome = Outcome(RunStatus.LINK_LOST, "the port is gone")
    track = Track()
    for number in range(poses):
        track.add(0.02 * number, mission.launch.pose, Pose2(0.0, 0.0, 0.0), 0.01, 0.01)
    figures = LinkFigures(**{field.name: 0 for field in fields(LinkFigures)})
    result = assemble(survey, track, figures, identities_of(mission, "device", 1, "", None), None, tmp_path)
    assert write_outputs(replace(result, out=str(tmp_path)), survey, track).unwritten == ()
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["status"], summary["reason"]) == ("link_lost", "the port is gone")
    assert {"report.html", "map.png", "trajectory.tum"} <= {path.name for path in tmp_path.iterdir()}
