"""`rover hil` and what it writes: text, JSON, JUnit XML, and a page that needs nothing else."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from rover.cli.main import invoke
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.scenario.library import FOLDER

WRONG = (FOLDER / "stop-command.toml").read_text().replace('cause = "StopCommand"', 'cause = "Stall"')


@pytest.fixture(autouse=True)
def _firmware() -> None:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))


@pytest.mark.rig("sitl")
def test_a_passing_run_writes_all_its_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    junit, page = tmp_path / "out" / "junit.xml", tmp_path / "page.html"
    assert invoke(["hil", "run", "stop-command", "--junit", str(junit), "--html", str(page), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (scenario,) = document["scenarios"]
    assert (scenario["passed"], scenario["state"], scenario["cause"]) == (True, "Latched", "StopCommand")
    assert all(verdict["passed"] for verdict in scenario["verdicts"])
    suite = ElementTree.parse(junit).getroot().find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures")) == ("1", "0")
    text = page.read_text()
    assert "All 1 passed" in text
    assert text.count("<svg") == 1
    assert not re.search(r'(src|href)="(?!#|data:)', text), "the page must need nothing else"


@pytest.mark.rig("sitl")
def test_a_failing_run_says_what_was_asked_and_what_was_seen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, junit, page = tmp_path / "wrong.toml", tmp_path / "junit.xml", tmp_path / "page.html"
    file.write_text(WRONG)
    assert invoke(["hil", "run", str(file), "--junit", str(junit), "--html", str(page)]) == 6
    printed = capsys.readouterr().out
    assert "expect-1: state == Stopping and cause == Stall" in printed
    assert "cause is StopCommand" in printed
    case = ElementTree.parse(junit).getroot().find("testsuite/testcase")
    assert case is not None
    failure = case.find("failure")
    assert failure is not None
    assert "cause == Stall" in str(failure.get("message"))
    assert "1 of 1 failed" in page.read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "name the scenarios to run, or give --all"),
        (["run", "serial-cut", "--all"], "name the scenarios to run, or give --all"),
        (["run", "seriel"], "seriel: no such scenario; similar: serial-cut"),
        (["run", "serial-cut", "--rig", "device"], "it cannot run on device"),
    ],
)
def test_a_wrong_command_line_is_one_line(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert invoke(["hil", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_the_list_names_scenarios_and_faults(capsys: pytest.CaptureFixture[str]) -> None:
    assert invoke(["hil", "list", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {"serial-cut", "sonar-near"} <= {row["scenario"] for row in document["scenarios"]}
    assert all(Path(row["file"]).is_file() for row in document["scenarios"])
    assert {"bit-errors", "firmware-hang"} <= {row["fault"] for row in document["faults"]}
