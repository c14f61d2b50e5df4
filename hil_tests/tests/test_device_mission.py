"""`rover run --rig device` in real time: a free-running sitl in the place of the board, its camera on a socket.

The companion knows nothing of the simulation here: it has a port, a camera source and the clock on the wall. The truth
is asked of the rig when the mission is over.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import pytest
from rover.cli.main import invoke
from rover.errors import PreflightFailed
from rover.record.log_reader import Log
from rover_hil.serve import RIGS
from rover_hil.testing.served import ServedRig
from rover_protocol import messages

pytestmark = pytest.mark.rig("sitl in place of a device")
MISSIONS = Path(__file__).resolve().parent / "missions"
SEED = 3
PATIENCE = 120.0


@dataclass
class Rover:
    """A free-running rig with its world's mission, and the companion's command line for it."""

    rig: ServedRig
    folder: Path

    def start(self, mission: str, *options: str) -> subprocess.Popen[str]:
        """`rover run` as a process of its own."""
        command = [sys.executable, "-m", "rover.cli.main", "run", str(MISSIONS / f"{mission}.toml")]
        command += ["--rig", "device", "--port", self.rig.port, "--camera-source", self.rig.camera_source]
        command += ["--seed", str(SEED), "--out", str(self.folder / "run"), "--force", *options]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run(self, mission: str, *options: str) -> tuple[int, str, str]:
        """To its end: exit code, stdout, stderr."""
        process = self.start(mission, *options)
        out, err = process.communicate(timeout=PATIENCE)
        return process.returncode, out, err

    def wait_until_it_drives(self, process: subprocess.Popen[str]) -> None:
        """The log shows what the companion does; a display would not in a pipe."""
        log, deadline = self.folder / "run" / "mission.mcap", time.monotonic() + 60.0
        while time.monotonic() < deadline and process.poll() is None:
            if log.exists() and any(Log(log).messages(("/motion/segments",))):
                return
            time.sleep(0.3)
        raise AssertionError(f"it does not drive: {process.communicate()[1]}")

    @property
    def log(self) -> Path:
        """Of the run."""
        return self.folder / "run" / "mission.mcap"

    @property
    def summary(self) -> dict[str, Any]:
        """Of the run."""
        document: dict[str, Any] = json.loads((self.folder / "run" / "summary.json").read_text())
        return document

    def verdict(self) -> dict[str, Any]:
        """The referee of the rig on the run that is over."""
        (asked,) = Log(self.log).messages(("/referee/asked",))
        content = json.loads(asked.data)
        offset = rig_time_ahead(self.log)
        for zone in content["zones"]:
            zone["t"] += offset
            zone["until"] = None if zone["until"] is None else zone["until"] + offset
        for thing in (*content["zones"], *content["detections"]):
            if "anchor" in thing:
                thing["anchor"]["t"] += offset
        verdict: dict[str, Any] = self.rig.ask("judge", **content)["verdict"]
        return verdict


def rig_time_ahead(log: Path) -> float:
    """Seconds by which the rig's time is ahead of the companion's, by the clock exchanges in the log."""
    sent: dict[int, float] = {}
    offsets = []
    for message in Log(log).messages(("/link/tx", "/link/rx")):
        frame = json.loads(message.data)
        try:
            kind, raw = messages.decode(frame["id"], bytes.fromhex(frame["data"]))
        except ValueError:
            continue
        fields = cast(dict[str, int], raw)
        if kind.name == "ClockRequest":
            sent[fields["sequence"]] = message.time_ns * 1e-9
        elif kind.name == "ClockReply" and fields["sequence"] in sent:
            received = message.time_ns * 1e-9
            asked = sent[fields["sequence"]]
            offsets.append((received - asked, fields["receive_time"] * 1e-6 - 0.5 * (asked + received)))
    return min(offsets)[1]


@pytest.fixture
def rover(tmp_path: Path) -> Iterator[Callable[..., Rover]]:
    try:
        RIGS["sitl"].command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running: list[ServedRig] = []

    def start(mission: str, wire: str = "serial") -> Rover:
        options = ("--free-run", "--seed", str(SEED), "--transport", wire)
        running.append(ServedRig(str(MISSIONS / f"{mission}.toml"), *options))
        return Rover(running[-1], tmp_path)

    yield start
    for one in running:
        one.stop()


def test_a_whole_mission_in_real_time_keeps_the_invariants_and_replays_identically(rover, capsys):
    real = rover("real-time")
    code, out, err = real.run("real-time")
    assert code == 0, err
    assert "not known, nobody counts on a real field" in out
    assert err.count("rover: ok ") == 12, err

    told = real.summary
    assert (told["status"], told["rig"], told["wall_clock"]) == ("done", "device", None)
    for unknown in ("collisions", "keepout_violations", "unseen_ground_m2", "min_clearance_m", "wheel_over_mine"):
        assert told[unknown] is None
    assert told["localization"]["ate_rmse_m"] is None
    assert told["real_time"]["cycles"] > 500
    assert told["real_time"]["overruns"] <= told["real_time"]["cycles"]
    assert [each["class"] for each in told["detections"]] == ["surface"]

    truth = real.verdict()
    assert (truth["collisions"], truth["keepout_violations"], truth["wheel_over_mine"]) == (0, 0, 0)
    assert truth["unseen_ground_m2"] == 0.0
    assert truth["mines_with_contrast_found"] == truth["mines_with_contrast"] == 1

    assert invoke(["replay", str(real.log), "--json", "--quiet"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert (replayed["identical"], replayed["first_difference"]) == (True, None)
    assert replayed["frames"] > 100
    assert replayed["parts"]["companion"]["compared"] > 3000
    assert "firmware" not in replayed["parts"], "what entered a real rover's firmware is not in the log"
    assert invoke(["replay", str(real.log), "--set", "gain_velocity=100000"]) == 2


def test_over_can_a_mission_ends_at_its_time_limit_and_replays_identically(rover, capsys):
    real = rover("look", "can")
    code, _, err = real.run("look", "--quiet")
    assert code == 8, err
    assert real.summary["reason"] == "the time limit of 6 s ran out"
    assert real.verdict()["collisions"] == 0
    assert invoke(["replay", str(real.log), "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out)["identical"]


def test_ctrl_c_is_a_controlled_stop_and_a_lost_rover_is_told(rover):
    real = rover("look")
    process = real.start("look", "--quiet")
    real.wait_until_it_drives(process)
    process.send_signal(signal.SIGINT)
    assert process.wait(PATIENCE) == 5
    assert real.summary["status"] == "aborted"
    assert invoke(["status", "--port", real.rig.port]) == 0

    real.log.unlink()
    process = real.start("look", "--quiet")
    real.wait_until_it_drives(process)
    real.rig.process.kill()
    assert process.wait(PATIENCE) == 7
    assert real.summary["status"] == "link_lost"
    assert (real.folder / "run" / "report.html").exists()
    assert invoke(["replay", str(real.log), "--quiet"]) == 0


def test_nothing_moves_while_the_emergency_stop_is_pressed_or_the_camera_is_another(rover, tmp_path):
    real = rover("look")
    real.rig.ask("fault", fault="emergency-stop-input")
    other = (MISSIONS / "look.toml").read_text() + '\n[rover]\ncamera = "e6390-320"\n'
    (tmp_path / "other.toml").write_text(other.replace("[launch]", "[launch]\nsurveyed_radius_m = 0.45"))
    code, out, err = real.run(str(tmp_path / "other"))
    assert (code, out) == (3, "")
    assert "rover: FAILED emergency stop  pressed" in err
    assert "rover: FAILED camera          gives 160×120, the mission's e6390-320 has 320×240" in err
    assert "pre-flight failed: emergency stop, camera; nothing has moved" in err
    assert not real.log.exists()


def test_a_port_where_nobody_is_and_a_camera_that_is_none_are_one_line_each(rover, capsys, tmp_path):
    real = rover("look")
    mission = str(MISSIONS / "look.toml")
    camera = real.rig.camera_source
    out = ["--out", str(tmp_path / "run")]
    cases = [
        (["--port", "/nowhere/tty", "--camera-source", camera], 3, "cannot open the port /nowhere/tty"),
        (["--port", real.rig.port, "--camera-source", "simulator:demo"], 2, "holds pictures of another time"),
        (["--port", real.rig.port, "--camera-source", "socket:/nowhere"], 3, "pre-flight failed: camera"),
        (["--port", real.rig.port], 2, "which camera?"),
        (["--camera-source", camera], 2, "which board?"),
        (["--port", real.rig.port, "--data", str(tmp_path)], 2, "a real one has its own"),
    ]
    for options, code, line in cases:
        assert invoke(["run", mission, "--rig", "device", *options, *out, "--quiet"]) == code
        assert line in capsys.readouterr().err
