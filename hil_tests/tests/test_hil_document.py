"""docs/guide/scenarios.md names every fault and everything observed, and its example runs; results has every guard."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.scenario.catalogue import FAULTS
from rover_hil.scenario.mutate import load_mutations
from rover_hil.scenario.observation import FLAGS, NUMBERS, WORDS
from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play

DOCS = Path(__file__).resolve().parents[2] / "docs"
DOCUMENT = (DOCS / "guide/scenarios.md").read_text(encoding="utf-8")
GUARDS = (DOCS / "results/scenarios.md").read_text(encoding="utf-8")


def first_column(section: str) -> set[str]:
    body = DOCUMENT.split(section, 1)[1].split("\n\n## ", 1)[0].split("\n### ", 1)[0]
    return set(re.findall(r"^\| `([\w.-]+)` \|", body, re.MULTILINE))


def test_every_fault_has_its_row() -> None:
    assert first_column("### The faults") == set(FAULTS)


def test_everything_observed_has_its_row() -> None:
    assert {*NUMBERS, *FLAGS, *WORDS} <= first_column("A **condition**")


def test_every_guard_has_its_row() -> None:
    assert {mutation.guard for mutation in load_mutations()} <= set(
        re.findall(r"^\| ([^|]+) \|", GUARDS, re.MULTILINE)
    )


@pytest.mark.rig("sitl")
def test_the_example_runs_and_passes(tmp_path: Path) -> None:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    file = tmp_path / "jammed.toml"
    file.write_text(re.findall(r"```toml\n(.*?)```", DOCUMENT, re.DOTALL)[0])
    result = play(load_scenario(file), "sitl")
    assert result.passed, result.failures
