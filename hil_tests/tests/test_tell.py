"""`rover tell` speaks to a mission on its way, and a replay of what was said is the mission as it was driven."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary

pytestmark = [pytest.mark.rig("sitl"), pytest.mark.slow]

ROVER = str(Path(sys.executable).with_name("rover"))
MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"
PATIENCE_S = 120.0


class Running:
    """A mission on its way."""

    def __init__(self, out: Path, *options: str) -> None:
        self.out = out
        command = [ROVER, "run", str(MISSION), "--seed", "2", "--out", str(out), "--json", "--quiet", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def tell(self, *words: str) -> dict[str, Any]:
        done = self.ask(*words)
        assert done.returncode == 0, done.stderr
        told: dict[str, Any] = json.loads(done.stdout)
        return told

    def ask(self, *words: str) -> subprocess.CompletedProcess[str]:
        line = [ROVER, "tell", str(self.out), *words, "--json"]
        return subprocess.run(line, capture_output=True, text=True, timeout=60.0, check=False)

    def wait_until(self, *states: str) -> dict[str, Any]:
        deadline = time.monotonic() + PATIENCE_S
        while (told := self.tell("state"))["state"] not in states:
            assert time.monotonic() < deadline, told
        return told

    def end(self) -> tuple[int, dict[str, Any]]:
        printed, said = self.process.communicate(timeout=PATIENCE_S)
        assert printed, said
        return self.process.returncode, json.loads(printed)


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    # A path longer than a socket's address has room for.
    running = Running(tmp_path_factory.mktemp("told") / ("long-" * 20) / "run")
    deadline = time.monotonic() + PATIENCE_S
    while not (running.out / "tell.sock").exists():
        assert running.process.poll() is None, running.process.stderr
        assert time.monotonic() < deadline
        time.sleep(0.05)
    yield running
    running.process.kill()
    running.process.communicate()


def test_a_mission_is_paused_goes_on_leaves_a_goal_out_and_comes_home(mission: Running) -> None:
    assert mission.tell("state")["state"] in ("start", "look")
    mission.wait_until("drive")
    mission.tell("pause")
    stands = mission.wait_until("paused")
    assert stands["says"] == "paused: paused by the operator"
    time.sleep(0.5)
    still = mission.tell("state")
    assert still["time_s"] > stands["time_s"]
    assert (still["x"], still["y"]) == pytest.approx((stands["x"], stands["y"]), abs=0.01)

    unknown = mission.ask("skip", "place-99")
    assert unknown.returncode == 2
    assert "no such goal" in unknown.stderr
    assert still["goals"], "the field of this seed has nothing to inspect: the test needs another"
    assert still["goals"][0] not in mission.tell("skip", still["goals"][0])["goals"]

    mission.tell("go")
    mission.wait_until("drive", "decide", "inspect")
    mission.tell("home")
    code, summary = mission.end()
    assert (code, summary["status"], summary["reason"]) == (5, "aborted", "called home by the operator")
    assert summary["home"] == {"reached": True, "reason": "at the launch"}
    assert not (mission.out / "tell.sock").exists()

    over = mission.ask("state")
    assert over.returncode == 2
    assert "no mission runs there" in over.stderr

    replayed = subprocess.run(
        [ROVER, "replay", str(mission.out / "mission.mcap"), "--json"],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert json.loads(replayed.stdout)["identical"], replayed.stdout
