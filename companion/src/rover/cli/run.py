"""`rover run`: a mission from start to report."""

from __future__ import annotations

from contextlib import nullcontext
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.interrupt import operator_signals
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput
from rover.link.rig import RigName, TransportName

if TYPE_CHECKING:
    from rover.link.self_test import Finding
    from rover.report.result import RunResult

HELP = """Drive a mission, start to report.

MISSION is a TOML file, or the name of a mission that ships (demo). On a real rover (--rig device) a pre-flight check
comes first, one line on stderr for each thing; nothing moves when one of them fails. The first Ctrl-C is a controlled
stop, and so is a terminal that hangs up; the second is an emergency stop. The exit code tells how it ended: 0 done, 3
pre-flight failed, 4 no path, 5 ended by the operator, 6 safety stop, 7 link lost, 8 partial, can be resumed.

Every run has a folder of its own, made once the pre-flight check has passed. What --resume needs is written every few
seconds: a run that was cut off is gone on from, too. rover tell speaks to it on its way.

\b
Examples:
  rover run demo
  rover run demo --seed 3 --out runs/third
  rover run demo --transport can
  rover run demo --out runs/morning
  rover run demo --resume runs/morning --out runs/noon
  rover run noon.toml --after runs/morning --out runs/noon      the same field at another hour: both are fused
  rover run field.toml --data ~/pictures --quiet
  rover run field.toml --rig device --port /dev/ttyACM0 --camera-source v4l2:/dev/video0
  rover run field.toml --rig device --port can:socketcan:can0 --camera-source v4l2:0
  rover run demo --foxglove                    open ws://127.0.0.1:8765 in Foxglove
  rover run field.toml --key operator.pem      signs what the run leaves, see rover verify
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
        Path | None, typer.Option(metavar="DIR", help="Folder of the run, new or empty.  [default: runs/DATE-TIME-…]")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the run that is in --out; other files stay.")] = False,
    data: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder with landmines/: ground of real thermal pictures.")
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Folder of an earlier run of this field: go on with what it has learned."),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Folder of a survey of this field at another hour: both are fused."),
    ] = None,
    key: Annotated[
        Path | None,
        typer.Option(envvar="ROVER_KEY", metavar="FILE", help="Operator's Ed25519 key: signs the run's manifest."),
    ] = None,
    foxglove: Annotated[
        bool, typer.Option("--foxglove", help="Stream all of the log to Foxglove on this computer, too.")
    ] = False,
    foxglove_port: Annotated[
        int, typer.Option(min=0, max=65_535, metavar="P", help="Port for --foxglove; 0 takes a free one.")
    ] = 8765,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print the report to report.pdf, too.")] = False,
    attended: Annotated[
        bool | None,
        typer.Option(
            "--attended/--unattended",
            help="After a gap of the companion: ask whether to drive on, or end.  [default: ask on device]",
            show_default=False,
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress on stderr.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.live import MissionView
    from rover.mission.config import load
    from rover.mission.run_folder import check_free, new_folder

    loaded = load(mission)
    if data is not None and not data.is_dir():
        raise BadInput(f"--data {data}: no such folder")
    folder = out if out is not None else new_folder(loaded.name, datetime.now())
    check_free(folder, force)
    beginning = "looking at rover and camera" if rig is RigName.DEVICE else "laying the field and starting the rig"
    view = MissionView(f"{loaded.name}, rig {rig.value}, seed {seed}", quiet, beginning=beginning)

    from rover.mission.loop import Control
    from rover.mission.run import run_mission
    from rover.record.foxglove_stream import FoxgloveStream
    from rover.report.summary import summary

    control = Control(attended=attended if attended is not None else rig is RigName.DEVICE)
    stream = FoxgloveStream(foxglove_port, loaded.name) if foxglove else None
    if stream is not None:
        say(f"open {stream.url} in Foxglove")
    with stream or nullcontext(), view, operator_signals(control, view.say):
        result = run_mission(
            loaded,
            rig=rig.value,
            transport=transport.value,
            port=port,
            camera_source=camera_source,
            seed=seed,
            out=folder,
            force=force,
            data=data,
            resume=resume,
            after=after,
            on_status=view.show,
            on_finding=lambda finding: view.say(finding_line(finding)),
            control=control,
            live=stream,
            key=key,
            pdf=pdf,
        )
    for line in result.unwritten:
        say(line)
    if as_json:
        write_json(summary(result))
    else:
        write_text(summary_text(result, folder / "report.html", mission))
    return result.exit_code


def finding_line(finding: Finding) -> str:
    """A line of the pre-flight check."""
    return f"{'ok' if finding.ok else 'FAILED':<7}{finding.name:<16}{finding.detail}"


def summary_text(result: RunResult, report: Path, mission: str) -> str:
    """A few lines for a person; the last is the path of the report. `mission`: as it was given to the command."""
    from rover.mission.former_run import can_go_on_from
    from rover.outcome import RunStatus

    goals = sum(goal.reached for goal in result.goals)
    area = result.area_m2
    lines = [
        f"{result.mission}: {result.status}" + (f" ({result.reason})" if result.reason else ""),
        f"{result.duration:.0f} s, {result.distance:.1f} m driven, "
        f"{result.surveyed_area:.1f} of {area:.1f} m² surveyed, {goals} of {len(result.goals)} goals inspected, "
        f"{_count(len(result.detections), 'indication')}",
    ]
    lines += [
        f"  {d.id}: {d.kind}, p {d.p:.2f}, at {d.x:.2f}, {d.y:.2f} m ± {d.sigma:.2f} m"
        + ("" if d.inspected else f", not inspected: {d.why_not}")
        for d in result.detections
    ]
    if result.home is not None and not result.home.reached:
        lines.append(f"the rover is not at its launch: {result.home.reason}")
    if result.coverage is not None:
        lines.append(f"seen: {result.coverage}; {100.0 * result.coverage.required:g} % are required")
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
    if result.status is not RunStatus.DONE and can_go_on_from(report.parent):
        lines.append(f"to go on: rover run {mission} --resume {report.parent}")
    return "\n".join([*lines, str(report)])


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
