"""The locks hold what is asked for, with hashes, and nothing of where it was downloaded."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
REQUIREMENTS = ROOT / "requirements"
NAMES = ("run", "emulator", "console", "foxglove", "dev")
PROJECTS = ("protocol/python", "companion", "hil_tests")
OWN = {"rover", "rover-protocol", "rover-hil"}


def normalized(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def locked(name: str) -> dict[str, set[str]]:
    """Lock's name → {package: its pins, one for each range of Python versions}."""
    pins: dict[str, set[str]] = {}
    for package, version in re.findall(r"^([\w.-]+)==([^ ;]+)", (REQUIREMENTS / f"{name}.lock").read_text(), re.M):
        pins.setdefault(normalized(package), set()).add(version)
    return pins


def asked_for(name: str) -> set[str]:
    """Packages that requirements/NAME.in names; for `run` those of the projects, too."""
    lines = (REQUIREMENTS / f"{name}.in").read_text().splitlines()
    wanted = [line for line in lines if line and not line.startswith(("#", "-"))]
    if name == "run":
        for project in PROJECTS:
            table: dict[str, Any] = tomllib.loads((ROOT / project / "pyproject.toml").read_text())["project"]
            wanted += table.get("dependencies", [])
    return {normalized(re.split(r"[^\w.-]", line)[0]) for line in wanted} - OWN


@pytest.mark.parametrize("name", NAMES)
def test_what_is_asked_for_is_locked(name: str) -> None:
    assert asked_for(name) <= locked(name).keys(), "run 'make lock'"


@pytest.mark.parametrize("name", NAMES)
def test_every_pin_has_hashes_and_no_host(name: str) -> None:
    text = (REQUIREMENTS / f"{name}.lock").read_text()
    entries = re.split(r"\n(?=\S)", text.strip())
    assert [entry for entry in entries if "--hash=sha256:" not in entry] == []
    assert "://" not in text
    assert not re.search(r"^\s*--?(index|extra|find|trusted|e|r|c)\b", text, re.M)


def test_a_package_has_the_same_pins_in_every_lock() -> None:
    pins = [locked(name) for name in NAMES]
    for package in set.intersection(*(set(lock) for lock in pins)):
        assert len({frozenset(lock[package]) for lock in pins}) == 1, package
    dev = pins[-1]
    shared = pins[0].keys() & dev.keys()
    assert {package: dev[package] for package in shared} == {package: pins[0][package] for package in shared}


CARGO = re.compile(r"(?:\$\(CARGO\)|\bcargo|/maturin') (build|test|clippy|check|run|metadata|develop)\b")


def test_cargo_builds_what_is_locked_and_nothing_else() -> None:
    files = [ROOT / "Makefile", ROOT / ".ci" / "run", *ROOT.glob("firmware/*.sh"), *ROOT.glob("tools/*.sh")]
    called = [line for file in files for line in file.read_text().splitlines() if CARGO.search(line)]
    assert len(called) >= 4
    assert [line for line in called if "--locked" not in line] == []
    toolchain = (ROOT / "firmware" / "toolchain.sh").read_text()
    assert toolchain.count('cargo "$subcommand" --release --locked') == 2
