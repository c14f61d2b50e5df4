"""A bring-up from its first step to its report. Each result goes into the vehicle file at once: it can be resumed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.bringup.bench import Bench, StepFailed
from rover.bringup.helper import Helper
from rover.bringup.steps import STEPS, Outcome, Setting
from rover.errors import BadInput, LinkLost, RoverError
from rover.link.parameters import command_parameters
from rover.link.session import Link
from rover.report.markup import Html, pairs, paragraph, section, table, text
from rover.vehicle import load_vehicle
from rover.vehicle.file import example
from rover.vehicle.text import with_value
from rover.whole_file import write_whole


@dataclass(frozen=True)
class Done:
    """A step that has been made, now or before."""

    name: str
    ok: bool
    found: dict[str, Any]
    measured: dict[str, Any]
    message: str

    def as_dict(self) -> dict[str, Any]:
        """As `--json` tells it."""
        return {
            "name": self.name,
            "ok": self.ok,
            "found": self.found,
            "measured": self.measured,
            "message": self.message,
        }


def notes_of(vehicle: Path) -> Path:
    """Where it is noted which steps have been made."""
    return vehicle.with_suffix(".bringup.json")


def report_of(vehicle: Path) -> Path:
    """The report page."""
    return vehicle.with_suffix(".bringup.html")


def chosen(names: Sequence[str] | None, made: Sequence[Done]) -> list[str]:
    """The steps to make: those that are named, else those that have not been made well. Raises BadInput."""
    for name in names or ():
        if name not in STEPS:
            raise BadInput(f"--steps {name}: no such step; there is {', '.join(STEPS)}")
    if names:
        return [name for name in STEPS if name in names]
    well = {done.name for done in made if done.ok}
    return [name for name in STEPS if name not in well]


def load_notes(vehicle: Path) -> list[Done]:
    """Steps that have been made for this file before. Raises BadInput."""
    path = notes_of(vehicle)
    try:
        return [Done(**row) for row in json.loads(path.read_text(encoding="utf-8"))]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError) as error:
        raise BadInput(f"{path}: not a note of an earlier bring-up ({error}): take it away to begin anew") from None


def bring_up(
    link: Link,
    helper: Helper,
    path: Path,
    names: Sequence[str],
    made: Sequence[Done] = (),
    on_step: Callable[[Done], None] = lambda _: None,
) -> list[Done]:
    """Makes the steps in order, ends at the first that fails, and saves the board's parameters when none has.

    The vehicle file is made when it is not there. Raises BadInput, PreflightFailed, LinkLost.
    """
    if not path.exists():
        write_whole(path, example().encode())
    bench = Bench(link)
    results = {done.name: done for done in made}
    try:
        for name in names:
            bench.restore(load_vehicle(path).parameters())
            done = _step(name, Setting(bench, helper, load_vehicle(path)), path)
            results[name] = done
            _keep(path, list(results.values()))
            on_step(done)
            if not done.ok:
                break
    finally:
        bench.restore(load_vehicle(path).parameters())
    every = [results[name] for name in STEPS if name in results]
    if names and all(done.ok for done in every):
        command_parameters(link, "save")
    return every


def _step(name: str, setting: Setting, path: Path) -> Done:
    try:
        outcome = STEPS[name](setting)
    except LinkLost:
        raise
    except StepFailed as error:
        outcome = Outcome(False, str(error))
    if outcome.ok and outcome.entries:
        before = path.read_bytes()
        changed = before.decode()
        for entry in outcome.entries:
            changed = with_value(changed, *entry)
        write_whole(path, changed.encode())
        try:
            load_vehicle(path)
        except RoverError as error:
            write_whole(path, before)
            outcome = Outcome(False, f"the values found do not fit the file: {error}", outcome.found, outcome.measured)
    return Done(name, outcome.ok, dict(outcome.found), dict(outcome.measured), outcome.message)


def _keep(path: Path, results: Sequence[Done]) -> None:
    write_whole(notes_of(path), json.dumps([done.as_dict() for done in results], indent=1).encode())
    write_whole(report_of(path), page(path, results).encode())


def page(path: Path, results: Sequence[Done]) -> str:
    """The report: what was found and measured, and the vehicle file as it is now."""
    rows = [(text(done.name), text("well" if done.ok else "FAILED"), text(done.message)) for done in results]
    parts: list[Html] = [section("Steps", "steps", table(("step", "", "found"), rows))]
    for done in results:
        told = {**done.found, **done.measured}
        shown = [(key, text(json.dumps(value, ensure_ascii=False))) for key, value in told.items()]
        parts.append(section(done.name, done.name, paragraph(done.message), pairs(shown)))
    file = path.read_text(encoding="utf-8")
    body = "".join(str(part) for part in parts)
    style = "body{font-family:sans-serif;max-width:60em;margin:2em auto}td,th{padding:.2em .8em;text-align:left}"
    return (
        f"<!doctype html><meta charset=utf-8><title>Bring-up of {text(path.stem)}</title><style>{style}</style>"
        f"<h1>Bring-up of {text(path.stem)}</h1>{body}<h2>{text(path.name)}</h2><pre>{text(file)}</pre>\n"
    )
