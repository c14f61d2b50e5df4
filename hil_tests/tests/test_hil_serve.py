"""`rover hil serve`: a rig in real time that any client can use over its port, its camera and its control socket."""

from __future__ import annotations

import json
import math
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest
from rover.capture import open_source
from rover.errors import PreflightFailed
from rover_hil.serve import RIGS
from rover_hil.testing.firmware_talk import FirmwareTalk
from rover_hil.testing.served import ServedRig

# Bit of the flags of State.
EMERGENCY_INPUT = 1 << 1

Serve = Callable[..., ServedRig]


def serving(rig_name: str) -> Iterator[Serve]:
    """Serves rigs of that name and stops them at the end."""
    try:
        RIGS[rig_name].command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running: list[ServedRig] = []

    def start(*options: str) -> ServedRig:
        running.append(ServedRig("demo", "--rig", rig_name, *options))
        return running[-1]

    yield start
    for one in running:
        one.stop()


@pytest.fixture
def serve(rig_name: str) -> Iterator[Serve]:
    """Each of the rigs."""
    yield from serving(rig_name)


@pytest.fixture
def sitl() -> Iterator[Serve]:
    """For what does not depend on the rig."""
    yield from serving("sitl")


def test_the_first_line_tells_where_everything_is(serve: Serve) -> None:
    rig = serve("--free-run")
    assert set(rig.announcement) == {"port", "camera_source", "control", "pid"}
    assert rig.announcement["pid"] == rig.process.pid
    with FirmwareTalk(rig.port) as talk:
        talk.wait_for("State", lambda _: True, seconds=10.0)
        talk.hello()
        assert talk.wait_for("HelloBuild", lambda _: True, seconds=5.0)["accepted"] == 1
    frame = next(iter(open_source(rig.camera_source)))
    assert frame.size == (160, 120)
    assert abs(time.monotonic() - frame.time) < 5.0, "exposures are told by the system's clock"


def test_time_stands_still_until_a_client_says_go_and_when_it_says_pause(serve: Serve) -> None:
    rig = serve()
    first = rig.ask("tape")
    assert first["paused"]
    assert first["time_s"] == 0.0
    assert not rig.ask("go")["paused"]
    time.sleep(0.3)
    paused_at = rig.ask("pause")["time_s"]
    assert paused_at > 0.0
    time.sleep(0.1)
    assert rig.ask("tape")["time_s"] == paused_at


def test_a_tape_measures_the_true_floor(serve: Serve) -> None:
    rig = serve()
    launch = rig.ask("tape")
    assert launch["distance_m"] == 0.0
    assert launch["rover"] == {"x": 0.45, "y": 0.45, "heading_deg": pytest.approx(45.0)}
    between = rig.ask("tape", **{"from": [0.0, 0.0], "to": [3.0, 4.0]})
    assert (between["distance_m"], between["bearing_deg"]) == (5.0, pytest.approx(math.degrees(math.atan2(4.0, 3.0))))
    assert rig.ask("set_down", x=1.45, y=0.45, heading_deg=-90)["rover"]["heading_deg"] == pytest.approx(-90.0)
    carried = rig.ask("tape")
    assert (carried["distance_m"], carried["bearing_deg"]) == (pytest.approx(1.0), pytest.approx(0.0))
    assert rig.ask("tape", **{"from": "rover", "to": [1.45, 0.95]})["bearing_deg"] == pytest.approx(90.0)


def test_faults_have_the_scenarios_names_and_end_when_told_or_by_themselves(serve: Serve) -> None:
    rig = serve("--free-run")
    assert rig.ask("fault", fault="emergency-stop-input")["faults"] == ["emergency-stop-input"]
    with FirmwareTalk(rig.port) as talk:
        talk.hello()
        talk.wait_for("State", lambda state: bool(state["flags"] & EMERGENCY_INPUT), seconds=10.0)
        assert rig.ask("fault", end="emergency-stop-input")["faults"] == []
        talk.wait_for("State", lambda state: not state["flags"] & EMERGENCY_INPUT, seconds=10.0)
    begun = rig.ask("fault", fault="battery-sag", drop_v=1.0, duration_s=0.2)
    assert begun["faults"] == ["battery-sag"]
    deadline = time.monotonic() + 10.0
    while rig.ask("tape")["time_s"] < begun["time_s"] + 0.25 and time.monotonic() < deadline:
        time.sleep(0.02)
    assert rig.ask("fault", fault="sonar-near", name="wall", range_m=0.2)["faults"] == ["wall"]


@pytest.mark.rig("sitl")
def test_what_cannot_be_done_is_said_in_one_line(sitl: Serve) -> None:
    rig = sitl()
    assert rig.send(b"pause")["error"].startswith("request: not valid JSON")
    assert rig.send(b"[]")["error"] == 'request: a JSON object is expected, as {"op": "pause"}'
    words = "pause, go, fault, set_down, tape, motors, judge, stop"
    assert rig.send(b"{}")["error"] == f"request: op: missing; there is {words}"
    assert "did you mean pause?" in rig.refusal("pauze")
    assert "unknown key" in rig.refusal("go", fast=True)
    assert "'serial-cut' is not one of" in rig.refusal("fault", fault="serial-cut")
    assert "wheel: missing" in rig.refusal("fault", fault="encoder-stuck")
    assert "unknown key" in rig.refusal("fault", fault="obstacle-ahead", distance_m=1.0, duration_s=2.0)
    assert "is not active; there is none" in rig.refusal("fault", end="battery-sag")
    assert "x: -1 lies outside 0 to 3" in rig.refusal("set_down", x=-1, y=0)
    assert "'moon' is not one of rover, launch" in rig.refusal("tape", to="moon")
    assert "zones have t, id" in rig.refusal("judge", zones=[{"t": 0.0}])
    rig.ask("fault", fault="battery-sag", drop_v=1.0)
    assert "is there already" in rig.refusal("fault", fault="battery-sag", drop_v=2.0)


@pytest.mark.rig("sitl")
def test_several_clients_come_and_go_and_one_of_them_ends_it(sitl: Serve) -> None:
    rig = sitl()
    control = rig.announcement["control"]
    for _ in range(3):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as other:
            other.connect(control)
            other.sendall(b'{"op": "tape"}\n{"op": "tape"}\n')
            with other.makefile("rb") as replies:
                assert [json.loads(replies.readline())["ok"] for _ in range(2)] == [True, True]
    assert rig.ask("stop")["ok"]
    assert rig.process.wait(timeout=10.0) == 0
    assert not os.path.exists(os.path.dirname(control)), "nothing is left behind"


@pytest.mark.rig("sitl")
def test_the_referee_and_the_truth_are_told(sitl: Serve, tmp_path) -> None:
    rig = sitl("--out", str(tmp_path / "truth"), "--seed", "4")
    verdict = rig.ask("judge")["verdict"]
    assert (verdict["collisions"], verdict["wheel_over_mine"], len(verdict["mines"])) == (0, 0, 5)
    rig.ask("stop")
    assert rig.process.wait(timeout=10.0) == 0
    truth = json.loads((tmp_path / "truth" / "truth.json").read_text())
    assert (truth["rig"], truth["seed"]) == ("sitl", 4)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("demo", "--world", "w.toml"), "w.toml"),
        (("demo", "--rig", "device"), "a real board is there already"),
        (("no-such-mission.toml",), "no-such-mission.toml"),
        (("demo", "--data", "/nowhere"), "--data /nowhere: no such folder"),
    ],
)
def test_what_cannot_be_served_is_said_in_one_line(options: tuple[str, ...], says: str) -> None:
    command = [sys.executable, "-m", "rover.cli.main", "hil", "serve", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert says in done.stderr
