"""`rover run`: a mission from start to report."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.interrupt import operator_signals
from rover.cli.live import MissionView
from rover.cli.output import write_json, write_text
from rover.errors import BadInput
from rover.link.rig import RigName, TransportName

if TYPE_CHECKING:
    from rover.link.self_test import Finding
    from rover.report.result import RunResult

HELP = """Drive a mission, start to report.

MISSION is a TOML file, or the name of a mission that ships (demo). On a real rover (--rig device) a pre-flight check
comes first, one line on stderr for each thing; nothing moves when one of them fails. The first Ctrl-C is a controlled
stop, the second an emergency stop. The exit code tells how it ended: 0 done, 3 pre-flight failed, 4 no path, 5 ended by
the operator, 6 safety stop, 7 link lost, 8 partial.

\b
Examples:
  rover run demo
  rover run demo --seed 3 --out runs/third
  rover run demo --transport can
  rover run demo --resume runs/demo-1 --out runs/demo-1-more
  rover run field.toml --data ~/pictures --quiet
  rover run field.toml --rig device --port /dev/ttyACM0 --camera-source v4l2:/dev/video0
  rover run field.toml --rig device --port can:socketcan:can0 --camera-source v4l2:0
  rover run demo --json | jq '.detections[] | [.class, .x, .y]'
"""


def command(
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="Mission file, or the name of a shipped one.")],
    rig: Annotated[
        RigName, typer.Option(help="sitl: simulated field; emulator: emulated board; device: a real board.")
    ] = RigName.SITL,
    transport: Annotated[
        TransportName, typer.Option(help="The wire between companion and firmware of a simulated rig.")
    ] = TransportName.SERIAL,
    port: Annotated[str | None, typer.Option(metavar="P", help="Port of a real board, see rover status.")] = None,
    camera_source: Annotated[
        str | None,
        typer.Option(metavar="S", help="Camera of a real rover, as v4l2:/dev/video0.  [default: the mission's]"),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Fixes the simulated field and everything else random.")] = 1,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the run.  [default: runs/<mission>-<seed>]")
    ] = None,
    data: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder with landmines/: ground of real thermal pictures.")
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Folder of an earlier run of this field: go on with what it has learned."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress on stderr.")] = False,
) -> int:
    """See HELP."""
    from rover.mission.config import load

    loaded = load(mission)
    if data is not None and not data.is_dir():
        raise BadInput(f"--data {data}: no such folder")
    folder = _folder(out, loaded.name + ("" if resume is None else "-resumed"), seed)
    beginning = "looking at rover and camera" if rig is RigName.DEVICE else "laying the field and starting the rig"
    view = MissionView(f"{loaded.name}, rig {rig.value}, seed {seed}", quiet, beginning=beginning)

    from rover.mission.loop import Control
    from rover.mission.run import run_mission

    control = Control()
    with view, operator_signals(control, view.say):
        result = run_mission(
            loaded,
            rig=rig.value,
            transport=transport.value,
            port=port,
            camera_source=camera_source,
            seed=seed,
            out=folder,
            data=data,
            resume=resume,
            on_status=view.show,
            on_finding=lambda finding: view.say(finding_line(finding)),
            control=control,
        )
    if as_json:
        write_json(result.summary())
    else:
        write_text(summary_text(result, folder / "report.html"))
    return result.exit_code


def finding_line(finding: Finding) -> str:
    """A line of the pre-flight check."""
    return f"{'ok' if finding.ok else 'FAILED':<7}{finding.name:<16}{finding.detail}"


def summary_text(result: RunResult, report: Path) -> str:
    """A few lines for a person; the last is the path of the report."""
    from rover.outcome import RunStatus

    goals = sum(goal.reached for goal in result.goals)
    area = result.area_width * result.area_height
    lines = [
        f"{result.mission}: {result.status}" + (f" ({result.reason})" if result.reason else ""),
        f"{result.duration:.0f} s, {result.distance:.1f} m driven, "
        f"{result.surveyed_area:.1f} of {area:.1f} m² surveyed, {goals} of {len(result.goals)} goals inspected, "
        f"{_count(len(result.detections), 'indication')}",
    ]
    lines += [
        f"  {d.id}: {d.kind}, p {d.p:.2f}, at {d.x:.2f}, {d.y:.2f} m ± {d.sigma:.2f} m"
        + ("" if d.inspected else f", not inspected: {d.why_not or 'no reason given'}")
        for d in result.detections
    ]
    if result.found is not None:
        lines.append(f"mines found {result.found}")
    if result.safety.collisions is not None:
        violations = result.safety.keepout_violations
        lines.append(f"referee: {_count(result.safety.collisions, 'collision')}, {violations} keep-out violations")
    if result.real_time is not None:
        kept = result.real_time
        lines.append(
            f"{kept.overruns} of {kept.cycles} cycles began late, the longest took {1e3 * kept.longest_cycle:.0f} ms; "
            f"{kept.frames_dropped} pictures were not looked at"
        )
        lines.append(
            "collisions, keep-out violations and unseen ground driven on: not known, nobody counts on a real field"
        )
    if result.status is RunStatus.PARTIAL:
        lines.append(f"to go on: rover run MISSION --resume {report.parent}")
    return "\n".join([*lines, str(report)])


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")


def _folder(out: Path | None, mission: str, seed: int) -> Path:
    """The run's folder, by default named after mission and seed. Raises BadInput before anything has started."""
    name = re.sub(r"[^\w.-]+", "-", mission).strip("-.") or "mission"
    folder = out if out is not None else Path("runs") / f"{name}-{seed}"
    there = next(parent for parent in (folder, *folder.parents) if parent.exists())
    if not there.is_dir():
        raise BadInput(f"--out {folder}: cannot be made a folder: {there} is a file")
    return folder
