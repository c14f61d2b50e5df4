"""Every mistake ends with its exit code and one line that says what and where."""

from __future__ import annotations

import pytest
from rover.cli import doctor
from rover.errors import LinkLost


def assert_one_line(result, code: int, *parts: str) -> None:
    assert result.code == code
    assert result.out == ""
    assert result.err.startswith("rover: ")
    assert result.err.count("\n") == 1, result.err
    assert "Traceback" not in result.err
    for part in parts:
        assert part in result.err


def test_a_mission_file_that_does_not_exist(rover):
    assert_one_line(rover("run", "nowhere.toml"), 2, "nowhere.toml", "no such file")


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("max_duration_s", "max_duration", ("[mission]", "max_duration")),
        ("width_m = 2.0", 'width_m = "2 m"', ("[area]", "width_m")),
        ("width_m = 2.0", "width_cm = 200.0", ("[area]", "width")),
        ("[launch]", '[detector]\nmodel = "none.onnx"\n[launch]', ("[detector]", "none.onnx", "no such file")),
        ("[mission]", "[misson]", ("misson",)),
        ("goals = []", "goals = [", ("mission.toml",)),
    ],
    ids=["unknown key", "text for a length", "wrong unit", "missing model", "unknown section", "broken TOML"],
)
def test_a_mistake_in_the_mission_file_is_bad_input(rover, mission_file, tmp_path, old, new, parts):
    out = tmp_path / "out"
    assert_one_line(rover("run", mission_file(old, new), "--out", out), 2, "mission.toml", *parts)
    assert not out.exists()


def test_a_goal_inside_a_known_obstacle_has_no_path(rover, mission_file):
    assert_one_line(rover("run", mission_file("goals = []", "goals = [[1.0, 1.5]]")), 4, "goals entry 1", "obstacle")


def test_a_rig_that_is_not_known(rover, mission_file):
    assert_one_line(rover("run", mission_file(), "--rig", "moon"), 2, "--rig", "moon", "sitl")


@pytest.mark.parametrize("seed", ["x", "-1", "1.5"])
def test_a_seed_that_is_no_natural_number(rover, mission_file, seed):
    assert_one_line(rover("run", mission_file(), "--seed", seed), 2, "--seed")


def test_data_that_is_no_folder(rover, mission_file, tmp_path):
    assert_one_line(rover("run", mission_file(), "--data", tmp_path / "none"), 2, "--data", "no such folder")


def test_an_out_that_is_a_file(rover, mission_file):
    file = mission_file()
    assert_one_line(rover("run", file, "--out", file), 2, "--out", "folder")


@pytest.mark.parametrize(
    "arguments",
    [(), ("fly",), ("run",), ("status",), ("run", "demo", "--fast")],
    ids=lambda given: " ".join(given) or "nothing",
)
def test_wrong_usage(rover, arguments):
    assert_one_line(rover(*arguments), 2, "--help")


def test_a_port_that_does_not_exist(rover):
    assert_one_line(rover("status", "--port", "/dev/no-such-port"), 3, "/dev/no-such-port")


def test_an_unexpected_error_is_one_line_too(rover, monkeypatch):
    def fail(*_):
        raise RuntimeError("two\nlines")

    monkeypatch.delenv("ROVER_DEBUG", raising=False)
    monkeypatch.setattr(doctor, "examine", fail)
    assert_one_line(rover("doctor"), 1, "RuntimeError", "two lines", "ROVER_DEBUG")


def test_an_unexpected_error_shows_its_traceback_on_demand(rover, monkeypatch):
    def fail(*_):
        raise RuntimeError("deep inside")

    monkeypatch.setenv("ROVER_DEBUG", "1")
    monkeypatch.setattr(doctor, "examine", fail)
    result = rover("doctor")
    assert result.code == 1
    assert "Traceback" in result.err
    assert "deep inside" in result.err


@pytest.mark.parametrize(("error", "code"), [(KeyboardInterrupt(), 5), (LinkLost("link lost: gone"), 7)])
def test_an_interrupt_and_a_lost_link_have_their_own_codes(rover, monkeypatch, error, code):
    def fail(*_):
        raise error

    monkeypatch.setattr(doctor, "examine", fail)
    assert_one_line(rover("doctor"), code)
