"""A whole mission over CAN."""

from __future__ import annotations

import json

import pytest

MISSION = """
[mission]
name = "over-can"
time_of_day = "13:00"
max_duration_s = 120.0
[area]
width_m = 1.4
height_m = 1.4
[launch]
x_m = 0.4
y_m = 0.4
heading_deg = 45.0
[field]
rocks = 0
grass = 0
surface_mines = 1
buried_mine_depths_cm = []
"""


@pytest.mark.rig("sitl")
def test_a_mission_is_driven_to_its_end_over_can(rover, tmp_path) -> None:
    pytest.importorskip("rover_hil")
    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION)
    out = tmp_path / "run"
    result = rover("run", mission, "--transport", "can", "--out", out, "--seed", 3, "--quiet", "--json")
    assert result.code == 0, result.err
    told = json.loads(result.out)
    assert json.loads((out / "rig.json").read_text())["port"].startswith("can:slcan:/dev/")
    assert told["status"] == "done"
    assert [goal["reached"] for goal in told["goals"]] == [True]
    assert told["collisions"] == told["keepout_violations"] == 0
    assert told["unseen_ground_m2"] == 0.0
