"""`rover run` around a mission, which is a stand-in: what it hands on, what it prints, how it is stopped."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from rover.cli.live import MissionView
from rover.geometry import Pose2
from rover.mission.loop import Status
from rover.outcome import RunStatus
from rover.report.result import Identities, MapLayers, RunResult

RASTER = np.zeros((2, 2), np.float32)
LAYERS = MapLayers((0.0, 0.0), 1.0, RASTER, RASTER > 0, RASTER > 0)


def status(time: float) -> Status:
    return Status(
        time=time,
        phase="survey",
        firmware="Moving",
        x=1.0,
        y=2.0,
        heading=0.5,
        sigma=0.012,
        goals_done=1,
        goals=3,
        indications=2,
        surveyed=0.5,
        battery=None,
        lost_frames=0,
        round_trip=float("nan"),
        wall=time / 4.0,
    )


@pytest.fixture
def missions(monkeypatch):
    """Calls of run_mission; `during` happens inside it, `ends` is the status it ends with."""
    calls = SimpleNamespace(given={}, during=lambda control: None, ends=RunStatus.DONE, controls=[], unwritten=())

    def run_mission(mission, **given):
        calls.given = {"mission": mission, **given}
        for time in np.arange(0.0, 25.0, 0.5):
            given["on_status"](status(float(time)))
        calls.during(given["control"])
        return RunResult(
            mission=mission.name,
            status=RunStatus.ABORTED if given["control"].stop else calls.ends,
            reason="nothing is left",
            duration=25.0,
            distance=4.0,
            area_width=2.0,
            area_height=2.0,
            launch=Pose2(0.5, 0.5, 0.0),
            path=np.zeros((0, 3)),
            layers=LAYERS,
            identities=Identities("sitl", given["seed"], "0"),
            link={"round_trip_median": float("nan")},
            out=str(given["out"]),
            unwritten=calls.unwritten,
        )

    module = ModuleType("rover.mission.run")
    module.run_mission = run_mission
    monkeypatch.setitem(sys.modules, "rover.mission.run", module)
    return calls


def test_json_is_one_document_and_alone_on_stdout(rover, missions, mission_file, tmp_path):
    result = rover("run", mission_file(), "--json", "--seed", 7, "--out", tmp_path / "out")
    summary = json.loads(result.out)
    assert (result.code, summary["status"], summary["seed"]) == (0, "done", 7)
    assert summary["out"] == str(tmp_path / "out")


def test_the_report_is_the_last_line(rover, missions, mission_file, tmp_path):
    result = rover("run", mission_file(), "--out", tmp_path / "out")
    assert result.out.splitlines()[0] == "small: done (nothing is left)"
    assert result.out.splitlines()[-1] == str(tmp_path / "out" / "report.html")


def test_the_default_folder_is_one_that_no_run_has_had(rover, missions, mission_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rover("run", mission_file('"small"', '"north/field 3"'))
    first = missions.given["out"]
    assert re.fullmatch(r"runs/\d{8}-\d{6}-north-field-3", str(first))
    first.mkdir(parents=True)
    rover("run", mission_file('"small"', '"north/field 3"'))
    assert missions.given["out"] != first


@pytest.mark.parametrize(("ends", "hinted"), [("partial", True), ("aborted", True), ("done", False)])
def test_how_to_go_on_is_said_wherever_that_works(rover, missions, mission_file, tmp_path, ends, hinted):
    missions.ends = RunStatus(ends)
    file, out = mission_file(), tmp_path / "out"
    hint = f"to go on: rover run {file} --resume {out}"
    assert hint not in rover("run", file, "--out", out).out
    out.mkdir()
    for name in ("survey.npz", "keyframes.npz"):
        (out / name).touch()
    assert (hint in rover("run", file, "--out", out, "--force").out) is hinted


def test_what_could_not_be_written_is_told(rover, missions, mission_file, tmp_path):
    missions.unwritten = ("map.png was not written: No space left on device",)
    result = rover("run", mission_file(), "--out", tmp_path / "out", "--quiet")
    assert result.err == "rover: map.png was not written: No space left on device\n"


@pytest.mark.parametrize(("ends", "code"), [("partial", 8), ("link_lost", 7), ("safety_stop", 6), ("no_path", 4)])
def test_the_exit_code_is_that_of_the_result(rover, missions, mission_file, tmp_path, ends, code):
    missions.ends = RunStatus(ends)
    assert rover("run", mission_file(), "--out", tmp_path / "out").code == code


def test_progress_is_a_line_every_ten_seconds_when_nobody_watches(rover, missions, mission_file, tmp_path):
    lines = rover("run", mission_file(), "--out", tmp_path / "out").err.splitlines()
    assert [line.partition(";")[0] for line in lines[1:]] == [f"rover: time {t}.0 s" for t in (0, 10, 20)]
    assert "surveyed 50 %" in lines[1]


def test_quiet_says_nothing(rover, missions, mission_file, tmp_path):
    assert rover("run", mission_file(), "--quiet", "--out", tmp_path / "out").err == ""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_request_to_end_and_a_terminal_that_hangs_up_stop_in_order(rover, missions, mission_file, tmp_path, number):
    seen = []

    def hang_up(control):
        os.kill(os.getpid(), number)
        seen.append((control.stop, control.emergency))

    missions.during = hang_up
    assert rover("run", mission_file(), "--out", tmp_path / "out").code == 5
    assert seen == [(True, False)]


def test_the_first_interrupt_stops_and_the_second_cuts_the_motors(rover, missions, mission_file, tmp_path):
    seen = []

    def interrupt_twice(control):
        for _ in range(2):
            os.kill(os.getpid(), signal.SIGINT)
            seen.append((control.stop, control.emergency))

    missions.during = interrupt_twice
    before = signal.getsignal(signal.SIGINT)
    result = rover("run", mission_file(), "--out", tmp_path / "out")
    assert seen == [(True, False), (True, True)]
    assert result.code == 5
    assert "emergency stop" in result.err
    assert signal.getsignal(signal.SIGINT) is before


def test_a_third_interrupt_ends_the_program(rover, missions, mission_file, tmp_path):
    missions.during = lambda _: [os.kill(os.getpid(), signal.SIGINT) for _ in range(3)]
    result = rover("run", mission_file(), "--out", tmp_path / "out")
    assert (result.code, result.out) == (5, "")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("colour", [True, False])
def test_a_terminal_gets_a_panel_and_no_colour_is_honoured(monkeypatch, colour):
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    if not colour:
        monkeypatch.setenv("NO_COLOR", "1")
    stream = Terminal()
    with MissionView("[x] demo", stream=stream) as view:
        view.show(status(3.0))
        view.say("stopping")
    shown = stream.getvalue()
    assert "1/3" in shown
    assert "rover: stopping" in shown
    assert not any(f"\x1b[{code}m" in shown for code in range(30, 38))


def test_a_terminal_that_is_closed_does_not_end_the_mission():
    class Gone(io.StringIO):
        def write(self, _: str) -> int:
            raise BrokenPipeError

    with MissionView("demo", stream=Gone()) as view:
        view.show(status(0.0))
        view.say("stopping")
