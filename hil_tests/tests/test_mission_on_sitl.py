"""A whole mission by the command that an operator types: what it must not do, what it must find, what it leaves."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rover.record.ate import absolute_trajectory_error
from rover.record.tum import read_tum

from .small_mission import Run

pytestmark = pytest.mark.rig("sitl")

REPEATABLE = ("mission.mcap", "trajectory.tum", "truth.tum", "detections.local.json")


def test_the_mission_is_done(small_mission: Callable[..., Run]) -> None:
    mission = small_mission()
    assert mission.code == 0, mission.said
    assert mission.summary["status"] == "done"
    assert mission.summary["reason"]
    assert (mission.summary["mission"], mission.summary["rig"], mission.summary["seed"]) == ("small", "sitl", 1)


@pytest.mark.parametrize("seed", [1, 2])
def test_it_hits_nothing_enters_no_zone_and_drives_only_on_seen_ground(
    small_mission: Callable[..., Run], seed: int
) -> None:
    summary = small_mission(seed).summary
    assert summary["collisions"] == 0
    assert summary["keepout_violations"] == 0
    assert summary["unseen_ground_m2"] == 0.0
    assert summary["wheel_over_mine"] == 0
    assert summary["min_clearance_m"] > 0.0
    assert summary["distance_m"] > 0.5  # a rover that never left the launch would pass all of this


@pytest.mark.parametrize("seed", [1, 2])
def test_the_surface_mine_is_reported_within_ten_centimetres(small_mission: Callable[..., Run], seed: int) -> None:
    mission = small_mission(seed)
    (mine,) = (mine for mine in mission.truth["mines"] if mine["kind"] == "surface")
    near = [
        found
        for found in mission.summary["detections"]
        if math.hypot(found["x"] - mine["x"], found["y"] - mine["y"]) <= 0.10
    ]
    assert len(near) == 1
    assert near[0]["class"] == "surface"
    assert near[0]["inspected"]


def test_the_summary_adds_up(small_mission: Callable[..., Run]) -> None:
    summary = small_mission().summary
    assert summary["surveyed_m2"] + sum(part["area_m2"] for part in summary["unsurveyed"]) == pytest.approx(
        summary["area_m2"], abs=2e-3
    )
    assert all(part["reason"] for part in summary["unsurveyed"])
    assert summary["surveyed_m2"] >= 0.9 * summary["area_m2"]
    assert all(goal["reached"] or goal["reason"] for goal in summary["goals"])
    assert all(0.0 <= found["first_seen_s"] <= summary["duration_s"] for found in summary["detections"])


def test_the_estimated_path_is_the_real_one_within_five_centimetres(small_mission: Callable[..., Run]) -> None:
    mission = small_mission()
    estimate, truth = read_tum(mission.out / "trajectory.tum"), read_tum(mission.out / "truth.tum")
    error = absolute_trajectory_error(estimate, truth)
    assert error <= 0.05
    assert mission.summary["localization"]["ate_rmse_m"] == pytest.approx(error, abs=1e-4)
    assert mission.summary["localization"]["odometry_only_ate_rmse_m"] > 0.0
    assert estimate[-1, 0] - estimate[0, 0] == pytest.approx(mission.summary["duration_s"], abs=0.05)
    assert (np.diff(estimate[:, 0]) > 0.0).all()


def test_what_is_printed_is_what_is_written(small_mission: Callable[..., Run]) -> None:
    mission = small_mission()
    assert json.loads(mission.printed) == mission.summary
    assert mission.summary["out"] == str(mission.out)


def test_the_log_holds_every_part_of_the_mission(small_mission: Callable[..., Run]) -> None:
    mission = small_mission()
    times: list[int] = []
    topics: Counter[str] = Counter()
    with (mission.out / "mission.mcap").open("rb") as file:
        for _, channel, message in make_reader(file, validate_crcs=True).iter_messages(log_time_order=False):
            topics[channel.topic] += 1
            times.append(message.log_time)
    link = mission.summary["link"]
    assert topics["/link/rx"] == link["frames_received"]
    assert topics["/link/tx"] == link["frames_sent"]
    duration = mission.summary["duration_s"]
    assert topics["/camera/thermal"] == pytest.approx(duration / 0.12, abs=5)
    assert topics["/pose"] >= 0.9 * topics["/camera/thermal"]
    for topic in ("/telemetry/FirmwareState", "/telemetry/Battery", "/telemetry/SonarRange", "/plan/path", "/log"):
        assert topics[topic] > 0, topic
    assert (max(times) - min(times)) * 1e-9 == pytest.approx(duration, abs=1.0)


def test_the_folder_is_complete_and_its_files_agree(small_mission: Callable[..., Run]) -> None:
    mission = small_mission()
    assert (mission.out / "map.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    report = (mission.out / "report.html").read_text()
    assert "</html>" in report
    assert 'src="http' not in report
    features = json.loads((mission.out / "detections.local.json").read_text())["features"]
    listed = {(found["id"], found["class"]) for found in mission.summary["detections"]}
    assert listed <= {(f["properties"].get("id"), f["properties"].get("class")) for f in features}
    assert mission.truth["verdict"]["collisions"] == mission.summary["collisions"]
    rig = json.loads((mission.out / "rig.json").read_text())
    assert not Path(f"/proc/{rig['pid']}").exists()
    assert not Path(rig["control"]).parent.exists()


def test_the_same_seed_gives_the_same_bytes(small_mission: Callable[..., Run]) -> None:
    first, second = small_mission(), small_mission(repetition=2)
    assert second.comparable == first.comparable
    different = [name for name in REPEATABLE if (first.out / name).read_bytes() != (second.out / name).read_bytes()]
    assert different == []


def test_another_seed_is_another_field_and_another_mission(small_mission: Callable[..., Run]) -> None:
    first, other = small_mission(), small_mission(seed=2)
    assert other.code == 0, other.said
    assert other.truth["mines"] != first.truth["mines"]
    assert other.comparable != first.comparable
    assert (other.out / "trajectory.tum").read_bytes() != (first.out / "trajectory.tum").read_bytes()
