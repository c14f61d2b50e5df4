"""A whole mission by the command that an operator types: what it must not do, what it must find, what it leaves."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rover.errors import PreflightFailed
from rover.record.ate import absolute_trajectory_error
from rover.record.tum import read_tum
from rover_hil.firmware_process import find_binary

pytestmark = pytest.mark.rig("sitl")

MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"
REPEATABLE = ("mission.mcap", "trajectory.tum", "truth.tum", "detections.local.json")


@dataclass(frozen=True)
class Run:
    """One mission that has ended: exit code, what it printed, its folder."""

    code: int
    printed: str
    said: str
    out: Path

    @cached_property
    def summary(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "summary.json").read_text())
        return document

    @cached_property
    def truth(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "truth.json").read_text())
        return document

    @property
    def comparable(self) -> str:
        """summary.json without what may differ from run to run; the order of keys and every digit count."""
        return json.dumps({key: value for key, value in self.summary.items() if key not in ("wall_clock", "out")})


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Run]:
    """Runs the small mission with a seed; each (seed, repetition) once."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    done: dict[tuple[int, int], Run] = {}

    def once(seed: int = 1, repetition: int = 1) -> Run:
        if (seed, repetition) not in done:
            out = tmp_path_factory.mktemp(f"seed{seed}-{repetition}")
            rover = str(Path(sys.executable).with_name("rover"))
            command = [rover, "run", str(MISSION), "--rig", "sitl", "--seed", str(seed), "--out", str(out), "--json"]
            ended = subprocess.run(command, capture_output=True, text=True, timeout=150.0)
            done[seed, repetition] = Run(ended.returncode, ended.stdout, ended.stderr, out)
        return done[seed, repetition]

    return once


def test_the_mission_is_done(run: Callable[..., Run]) -> None:
    mission = run()
    assert mission.code == 0, mission.said
    assert mission.summary["status"] == "done"
    assert mission.summary["reason"]
    assert (mission.summary["mission"], mission.summary["rig"], mission.summary["seed"]) == ("small", "sitl", 1)


@pytest.mark.parametrize("seed", [1, 2])
def test_it_hits_nothing_enters_no_zone_and_drives_only_on_seen_ground(run: Callable[..., Run], seed: int) -> None:
    summary = run(seed).summary
    assert summary["collisions"] == 0
    assert summary["keepout_violations"] == 0
    assert summary["unseen_ground_m2"] == 0.0
    assert summary["wheel_over_mine"] == 0
    assert summary["min_clearance_m"] > 0.0
    assert summary["distance_m"] > 0.5  # a rover that never left the launch would pass all of this


@pytest.mark.parametrize("seed", [1, 2])
def test_the_surface_mine_is_reported_within_ten_centimetres(run: Callable[..., Run], seed: int) -> None:
    mission = run(seed)
    (mine,) = (mine for mine in mission.truth["mines"] if mine["kind"] == "surface")
    near = [
        found
        for found in mission.summary["detections"]
        if math.hypot(found["x"] - mine["x"], found["y"] - mine["y"]) <= 0.10
    ]
    assert len(near) == 1
    assert near[0]["class"] == "surface"
    assert near[0]["inspected"]


def test_the_summary_adds_up(run: Callable[..., Run]) -> None:
    summary = run().summary
    assert summary["surveyed_m2"] + sum(part["area_m2"] for part in summary["unsurveyed"]) == pytest.approx(
        summary["area_m2"], abs=2e-3
    )
    assert all(part["reason"] for part in summary["unsurveyed"])
    assert summary["surveyed_m2"] >= 0.9 * summary["area_m2"]
    assert all(goal["reached"] or goal["reason"] for goal in summary["goals"])
    assert all(0.0 <= found["first_seen_s"] <= summary["duration_s"] for found in summary["detections"])


def test_the_estimated_path_is_the_real_one_within_five_centimetres(run: Callable[..., Run]) -> None:
    mission = run()
    estimate, truth = read_tum(mission.out / "trajectory.tum"), read_tum(mission.out / "truth.tum")
    error = absolute_trajectory_error(estimate, truth)
    assert error <= 0.05
    assert mission.summary["localization"]["ate_rmse_m"] == pytest.approx(error, abs=1e-4)
    assert mission.summary["localization"]["odometry_only_ate_rmse_m"] > 0.0
    assert estimate[-1, 0] - estimate[0, 0] == pytest.approx(mission.summary["duration_s"], abs=0.05)
    assert (np.diff(estimate[:, 0]) > 0.0).all()


def test_what_is_printed_is_what_is_written(run: Callable[..., Run]) -> None:
    mission = run()
    assert json.loads(mission.printed) == mission.summary
    assert mission.summary["out"] == str(mission.out)


def test_the_log_holds_every_part_of_the_mission(run: Callable[..., Run]) -> None:
    mission = run()
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


def test_the_folder_is_complete_and_its_files_agree(run: Callable[..., Run]) -> None:
    mission = run()
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


def test_the_same_seed_gives_the_same_bytes(run: Callable[..., Run]) -> None:
    first, second = run(), run(repetition=2)
    assert second.comparable == first.comparable
    different = [name for name in REPEATABLE if (first.out / name).read_bytes() != (second.out / name).read_bytes()]
    assert different == []


def test_another_seed_is_another_field_and_another_mission(run: Callable[..., Run]) -> None:
    first, other = run(), run(seed=2)
    assert other.code == 0, other.said
    assert other.truth["mines"] != first.truth["mines"]
    assert other.comparable != first.comparable
    assert (other.out / "trajectory.tum").read_bytes() != (first.out / "trajectory.tum").read_bytes()
