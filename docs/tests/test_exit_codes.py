"""An exit code means one thing: in the code, on the pages, in the help, in the scenarios."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rover.cli import run
from rover.errors import (
    EXIT_CODES,
    Aborted,
    BadInput,
    LinkLost,
    NoPath,
    PreflightFailed,
    RoverError,
    SafetyStop,
)
from rover.outcome import Outcome, RunStatus
from rover_hil.scenario.companion_process import WORDS

COMMANDS = (Path(__file__).parents[1] / "reference" / "commands.md").read_text(encoding="utf-8")
BY_STATUS = {
    RunStatus.DONE: "done",
    RunStatus.NO_PATH: "no path",
    RunStatus.ABORTED: "ended by the operator",
    RunStatus.SAFETY_STOP: "safety stop",
    RunStatus.LINK_LOST: "link lost",
    RunStatus.PARTIAL: "partial, can be resumed",
}


def test_every_way_in_which_a_mission_ends_has_the_code_of_that_meaning() -> None:
    assert {status: EXIT_CODES[status.exit_code] for status in RunStatus} == BY_STATUS


def test_every_error_has_a_code_of_its_own() -> None:
    kinds: list[type[RoverError]] = [RoverError, BadInput, PreflightFailed, NoPath, Aborted, SafetyStop, LinkLost]
    assert [kind.exit_code for kind in kinds] == sorted(set(EXIT_CODES) - {0, 8})


@pytest.mark.parametrize("code", EXIT_CODES)
def test_the_page_says_the_same(code: int) -> None:
    (row,) = re.findall(rf"^\| {code} \| ([^|]+) \|$", COMMANDS, re.MULTILINE)
    assert row.startswith(EXIT_CODES[code])


def test_the_help_of_a_mission_says_the_same() -> None:
    said = re.search(r"how it ended: ([^.]+)\.", " ".join(run.HELP.split()))
    assert said is not None
    told = dict(re.findall(r"(\d) (.+?)(?=, \d |$)", said[1]))
    assert told == {str(code): EXIT_CODES[code] for code in (0, 3, 4, 5, 6, 7, 8)}


def test_the_scenarios_know_each_end_by_the_same_code() -> None:
    wanted = {0: "Done", 3: "PreflightFailed", 4: "NoPath", 5: "Aborted", 6: "SafetyStop", 7: "LinkLost", 8: "Partial"}
    assert wanted == WORDS


def test_an_end_without_a_reason_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="without a reason"):
        Outcome(RunStatus.PARTIAL, " ")
