"""When an expectation holds, comes too late or too early, and what the end says."""

from __future__ import annotations

from pathlib import Path

import pytest
from rover_hil.scenario.judge import Judge
from rover_hil.scenario.language import Scenario
from rover_hil.scenario.observation import Moment
from rover_hil.scenario.reading import load_scenario

FILE = """
name = "n"
description = "d"
rigs = ["sitl"]
[[inject]]
fault = "serial-cut"
at_s = 0.0
[[expect]]
name = "latched"
state = "Latched"
not_before_s = 0.1
within_s = 0.5
moved_less_than_m = 0.2
[[expect]]
name = "quiet"
after = "latched"
speed_below = 0.01
from_s = 0.05
within_s = 0.3
[[never]]
until = "latched"
condition = "collisions > 0"
[end]
state = "Latched"
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Scenario:
    file = tmp_path / "one.toml"
    file.write_text(FILE)
    return load_scenario(file)


def moment(time: float, state: str = "Moving", speed: float = 0.2, way: float = 0.0, collisions: float = 0.0) -> Moment:
    return Moment(time, {"state": state, "speed": speed, "travelled_m": way, "collisions": collisions})


def judged(scenario: Scenario, *moments: Moment, over: bool = True) -> dict[str, tuple[bool, str]]:
    judge = Judge(scenario)
    judge.event("serial-cut", moment(1.0, way=0.5))
    for one in moments:
        judge.see(one)
    return {verdict.name: (verdict.passed, verdict.detail) for verdict in judge.finish(moments[-1], over)}


def test_what_comes_in_time_holds_and_is_the_event_for_the_next(scenario: Scenario) -> None:
    verdicts = judged(scenario, moment(1.3, "Latched", way=0.6), moment(1.5, "Latched", speed=0.0, way=0.6))
    assert all(passed for passed, _ in verdicts.values())


def test_what_comes_too_late_fails_and_says_what_was_seen(scenario: Scenario) -> None:
    verdicts = judged(scenario, moment(1.4), moment(1.51), moment(1.52, "Latched"))
    assert verdicts["latched"] == (False, "not within 0.5 s: state == Latched (but state is Moving)")
    assert verdicts["quiet"] == (False, "the run ended and latched never came")


def test_what_comes_too_early_fails(scenario: Scenario) -> None:
    assert judged(scenario, moment(1.05, "Latched", way=0.5))["latched"] == (False, "too early, after 0.050 s")


def test_what_is_the_case_before_it_is_looked_at_does_not_matter(scenario: Scenario) -> None:
    latched, still = moment(1.3, "Latched", way=0.5), moment(1.34, "Latched", speed=0.0, way=0.5)
    assert judged(scenario, latched, still)["quiet"] == (False, "the run ended")
    assert judged(scenario, latched, still, moment(1.4, "Latched", speed=0.0, way=0.5))["quiet"] == (True, "")


def test_a_way_counts_from_the_event_that_it_refers_to(scenario: Scenario) -> None:
    verdicts = judged(scenario, moment(1.3, "Latched", way=0.75), moment(1.6, "Latched", way=0.75))
    assert verdicts["latched"][0] is False
    assert "travelled_m is 0.750" in verdicts["latched"][1]


def test_what_must_never_be_is_seen_at_once_but_not_after_its_end(scenario: Scenario) -> None:
    assert judged(scenario, moment(1.2, collisions=1.0))["never-1"] == (False, "it was after 0.200 s")
    calm = judged(scenario, moment(1.3, "Latched", way=0.5), moment(1.4, "Latched", collisions=1.0))
    assert calm["never-1"] == (True, "")


def test_a_run_that_does_not_end_fails(scenario: Scenario) -> None:
    assert judged(scenario, moment(1.3, "Latched", way=0.5), over=False)["end"][0] is False
