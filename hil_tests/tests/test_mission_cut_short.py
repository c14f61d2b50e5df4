"""Missions that end in the middle of a drive: a killed companion, a wire pulled out, a Ctrl-C."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rover.errors import PreflightFailed
from rover.record.tum import read_tum
from rover_hil.firmware_process import find_binary
from rover_hil.testing.rigs import Client

pytestmark = pytest.mark.rig("sitl")

MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"
ROVER = Path(sys.executable).with_name("rover")
# Seconds of real time within which the rover has looked around and drives.
UNTIL_DRIVING = 90.0

ESCAPES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
MOMENT = re.compile(r"phase\s+(\w+).*?firmware\s+(\w+).*?pose\s+(-?[\d.]+), (-?[\d.]+) m", re.DOTALL)


class Mission:
    """`rover run` in a terminal, whose live panel is read: it is redrawn every half second of the mission."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self._terminal, far_end = pty.openpty()
        self._shown = ""
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "40"}
        with (out / "stdout").open("wb") as printed:
            self.process = subprocess.Popen(
                [ROVER, "run", MISSION, "--seed", "1", "--out", out, "--force", "--json"],
                stdin=subprocess.DEVNULL,
                stdout=printed,
                stderr=far_end,
                env=environment,
            )
        os.close(far_end)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError):  # the other end is closed: the command has ended
            while data := os.read(self._terminal, 65_536):
                self._shown += data.decode("utf-8", "replace")

    @property
    def shown(self) -> str:
        """All that the terminal has shown, without its escapes."""
        return ESCAPES.sub("", self._shown)

    def wait_until_driving(self) -> None:
        """Returns when the panel shows the rover in the middle of a straight."""
        deadline = time.monotonic() + UNTIL_DRIVING
        while time.monotonic() < deadline:
            assert self.process.poll() is None, self.shown[-2000:]
            moments = MOMENT.findall(self.shown[-6000:])[-2:]
            if len(moments) == 2 and all(phase == "drive" and state == "Moving" for phase, state, *_ in moments):
                before, after = (np.array([float(x), float(y)]) for _, _, x, y in moments)
                if np.linalg.norm(after - before) >= 0.05:
                    return
            time.sleep(0.005)
        pytest.fail(f"the rover did not drive within {UNTIL_DRIVING:g} s:\n{self.shown[-2000:]}")

    @property
    def rig(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "rig.json").read_text())
        return document

    @property
    def firmware_pids(self) -> list[int]:
        """The processes of the rover-sitl that the rig has started."""
        children = Path(f"/proc/{self.rig['pid']}/task/{self.rig['pid']}/children")
        return [int(pid) for pid in children.read_text().split()]

    @property
    def summary(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "summary.json").read_text())
        return document

    def topics(self) -> set[str]:
        """Topics with at least one readable message in mission.mcap."""
        with (self.out / "mission.mcap").open("rb") as file:
            return {channel.topic for _, channel, _ in make_reader(file, validate_crcs=True).iter_messages()}

    def close(self) -> None:
        """Ends what is left: the command, and the rig, which outlives it on purpose."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        if (self.out / "rig.json").exists() and runs(self.rig["pid"]):
            os.kill(self.rig["pid"], signal.SIGTERM)
            gone_within(5.0, self.rig["pid"])
        if (self.out / "rig.json").exists():
            # A killed command cannot take the folder of the rig's socket away.
            with contextlib.suppress(FileNotFoundError):
                Path(self.rig["control"]).parent.rmdir()
        os.close(self._terminal)


def runs(pid: int) -> bool:
    """True while the process lives; a zombie that nobody has waited for does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def gone_within(seconds: float, pid: int) -> bool:
    deadline = time.monotonic() + seconds
    while runs(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not runs(pid)


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[Mission]:
    """A mission in the middle of a straight."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running = Mission(tmp_path)
    try:
        running.wait_until_driving()
        yield running
    finally:
        running.close()


def speeds(truth: np.ndarray) -> np.ndarray:
    """Speed (n - 1,) along the real trajectory (n, 4), m/s."""
    along: np.ndarray = np.hypot(*np.diff(truth[:, 1:3], axis=0).T)
    return along / np.diff(truth[:, 0])


def test_when_the_companion_is_killed_the_firmware_stops_the_rover_and_says_so(mission: Mission) -> None:
    mission.process.kill()
    mission.process.wait()
    time.sleep(2.0)
    assert runs(mission.rig["pid"])
    asked = subprocess.run(
        [ROVER, "status", "--port", mission.rig["port"], "--json"], capture_output=True, text=True, timeout=30.0
    )
    assert asked.returncode == 0, asked.stderr
    answer = json.loads(asked.stdout)
    assert (answer["state"], answer["cause"], answer["moving"], answer["powered"]) == (
        "Latched",
        "DeadMan",
        False,
        False,
    )
    assert "dead-man" in answer["meaning"]

    client = Client(mission.rig["control"])
    client.ask(op="hello")
    verdict, _ = client.ask(op="finish", zones=[], detections=[])
    client.socket.close()
    assert verdict["collisions"] == 0
    truth = read_tum(mission.out / "truth.tum")
    speed = speeds(truth)
    moving = np.flatnonzero(speed > 0.02)
    # It drove until the end came, then stopped within the dead-man's 0.3 s and the braking, and has stood since.
    assert truth[-1, 0] - truth[moving[-1], 0] >= 1.0
    assert speed[moving[-1] - 100 : moving[-1]].max() > 0.1
    assert gone_within(5.0, mission.rig["pid"])


def test_when_the_wire_is_pulled_the_mission_ends_with_a_complete_folder(mission: Mission) -> None:
    firmware = mission.firmware_pids
    os.kill(mission.rig["pid"], signal.SIGKILL)
    begin = time.monotonic()
    assert mission.process.wait(timeout=30.0) == 7, mission.shown[-2000:]
    assert time.monotonic() - begin < 10.0
    assert "Traceback" not in mission.shown
    summary = mission.summary
    assert summary["status"] == "link_lost"
    assert summary["reason"]
    assert json.loads((mission.out / "stdout").read_text()) == summary
    # Nobody was left to judge, which is not the same as nothing having happened.
    assert (summary["collisions"], summary["keepout_violations"], summary["unseen_ground_m2"]) == (None, None, None)
    assert summary["distance_m"] > 0.0
    assert {"/link/rx", "/link/tx", "/camera/thermal", "/pose", "/log"} <= mission.topics()
    assert (mission.out / "map.png").read_bytes().startswith(b"\x89PNG")
    assert "</html>" in (mission.out / "report.html").read_text()
    json.loads((mission.out / "detections.local.json").read_text())
    track = read_tum(mission.out / "trajectory.tum")
    assert track[-1, 0] - track[0, 0] == pytest.approx(summary["duration_s"], abs=0.05)
    assert firmware
    assert all(gone_within(5.0, pid) for pid in firmware)


def test_one_interrupt_brings_the_rover_to_rest_and_writes_the_report(mission: Mission) -> None:
    mission.process.send_signal(signal.SIGINT)
    assert mission.process.wait(timeout=30.0) == 5, mission.shown[-2000:]
    summary = mission.summary
    assert (summary["status"], summary["reason"]) == ("aborted", "ended by the operator")
    assert (summary["collisions"], summary["keepout_violations"]) == (0, 0)
    assert any(part["reason"].startswith("the mission ended before") for part in summary["unsurveyed"])
    assert "report will be written" in mission.shown
    assert "</html>" in (mission.out / "report.html").read_text()
    truth = read_tum(mission.out / "truth.tum")
    speed = speeds(truth)
    assert (speed[truth[1:, 0] > truth[-1, 0] - 0.03] < 0.002).all()
    # It was the operator's stop that brought it to rest: just before, it drove, and it braked within its limits.
    assert speed[truth[1:, 0] > truth[-1, 0] - 2.5].max() > 0.1
    braking = -np.diff(np.convolve(speed, np.full(10, 0.1), "valid")) / 0.01
    assert braking[-250:].max() < 1.0
    assert not runs(mission.rig["pid"])
