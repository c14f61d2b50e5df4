"""`rover hil run` and `rover hil list`: fault scenarios on a rig, with reports for people and for a CI server."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput
from rover.link.rig import RigName

if TYPE_CHECKING:
    from rover_hil.scenario.runner import Result

RUN_HELP = """Run scenarios. SCENARIO is a file, a folder, or the name of one that ships; --all runs all that ship.

Exit codes: 0 all passed, 2 a file is wrong, 3 the rig does not start, 6 a scenario failed.

\b
Examples:
  rover hil run serial-cut
  rover hil run --all --rig sitl --html faults.html
  rover hil run my-fault.toml --json | jq '.scenarios[0].verdicts'
"""
LIST_HELP = """List the scenarios that ship, and the faults that a scenario may put in.

\b
Examples:
  rover hil list
  rover hil list --faults
  rover hil list --json | jq -r '.scenarios[] | select(.rigs | index("emulator")) | .file'
"""
FAILED = 6


def run(
    scenarios: Annotated[list[str] | None, typer.Argument(metavar="SCENARIO…", help="Names, files, folders.")] = None,
    every: Annotated[bool, typer.Option("--all", help="All scenarios that ship and can exist on this rig.")] = False,
    rig: Annotated[RigName, typer.Option(help="sitl: desktop process; emulator: emulated board.")] = (RigName.SITL),
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="Write JUnit XML.")] = None,
    html: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a page with plots.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as one JSON document.")] = False,
) -> int:
    """See RUN_HELP."""
    from rover_hil.scenario.junit import junit_xml
    from rover_hil.scenario.library import find, shipped
    from rover_hil.scenario.page import html_page
    from rover_hil.scenario.reading import load_scenario
    from rover_hil.scenario.runner import play

    if bool(scenarios) == every:
        raise BadInput("name the scenarios to run, or give --all ('rover hil list' shows them)")
    loaded = [load_scenario(file) for file in (shipped() if every else find(scenarios or []))]
    if every:
        loaded = [scenario for scenario in loaded if rig.value in scenario.rigs]
    for scenario in loaded:
        if rig.value not in scenario.rigs:
            raise BadInput(f"{scenario.path}: rigs is {', '.join(scenario.rigs)}: it cannot run on {rig.value}")
    results: list[Result] = []
    for scenario in loaded:
        result = play(scenario, rig.value)
        results.append(result)
        say(f"{'passed' if result.passed else 'FAILED'} {scenario.path.stem} ({result.simulated:.1f} s simulated)")
    if junit is not None:
        _write(junit, "--junit", junit_xml(results))
    if html is not None:
        _write(html, "--html", html_page(results))
    if as_json:
        write_json({"rig": rig.value, "scenarios": [_document(result) for result in results]})
    else:
        write_text(_text(results))
    return 0 if all(result.passed for result in results) else FAILED


def list_scenarios(
    faults: Annotated[bool, typer.Option("--faults", help="List the faults and what they take instead.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See LIST_HELP."""
    from rover_hil.scenario.catalogue import FAULTS
    from rover_hil.scenario.library import shipped
    from rover_hil.scenario.reading import load_scenario

    known = [{"fault": name, "what": f.doc, "takes": list(f.parameters), "rigs": f.rigs} for name, f in FAULTS.items()]
    loaded = [load_scenario(file) for file in shipped()]
    rows = [
        {"scenario": s.path.stem, "name": s.name, "rigs": s.rigs, "transport": s.transport, "file": str(s.path)}
        for s in loaded
    ]
    if as_json:
        write_json({"scenarios": rows, "faults": known})
    elif faults:
        write_text("\n".join(f"{k['fault']:24} {k['what']}" + _takes(k["takes"]) for k in known))
    else:
        width = max(len(str(row["scenario"])) for row in rows) if rows else 0
        write_text("\n".join(f"{row['scenario']!s:{width}}  {row['name']}" for row in rows))
    return 0


def _takes(parameters: Any) -> str:
    return f" ({', '.join(parameters)})" if parameters else ""


def _text(results: list[Result]) -> str:
    lines = []
    for result in results:
        if not result.passed:
            lines.append(f"{result.scenario.path}: {result.scenario.name}")
            lines += [f"  {failure}" for failure in result.failures]
    failed = sum(not result.passed for result in results)
    simulated, wall = sum(r.simulated for r in results), sum(r.wall for r in results)
    lines.append(f"{len(results) - failed} passed, {failed} failed, {simulated:.1f} s simulated in {wall:.1f} s")
    return "\n".join(lines)


def _document(result: Result) -> dict[str, Any]:
    last = result.track.last.values
    return {
        "scenario": result.scenario.path.stem,
        "name": result.scenario.name,
        "rig": result.rig,
        "passed": result.passed,
        "simulated_s": result.simulated,
        "wall_s": result.wall,
        "state": last["state"],
        "cause": last["cause"],
        "companion": last["companion"],
        "verdicts": [
            {"name": v.name, "asked": v.asked, "passed": v.passed, "after_s": v.at, "detail": v.detail}
            for v in result.verdicts
        ],
        "events": [{"t": time, "what": what} for time, what in result.track.events],
    }


def _write(path: Path, option: str, content: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{option} {path}: cannot be written: {error.strerror or error}") from error
