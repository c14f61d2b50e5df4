"""`rover replay`: a recorded stream back into a rig and the companion, every output held against the recorded one."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput
from rover.link.rig import RigName

if TYPE_CHECKING:
    from rover_hil.replay.play import Replayed

HELP = """Feed a recorded stream back, and compare every output with the recorded one.

LOG is the mission.mcap of a run: all that entered the rig's firmware goes into the firmware again, all that entered the
companion into its estimators and its mission. On the same build all outputs are equal; otherwise the first difference
is named: topic, time, field, recorded and replayed value. --set and --override change something on purpose.

With --rig emulator the log of a sitl run goes through the flashed ELF on the emulated board, tick by tick; only what
tells who the firmware is may differ. With --rig device a board on --port gets the recorded wheels, sonars and
commands in its test mode, in real time.

With --import a folder of frames and CSV files becomes a LOG that goes through the estimators, see
docs/reference/replay.md.

While it runs at a rate, the space bar or SIGUSR1 pauses it and lets it go on.

\b
Examples:
  rover replay runs/demo-1/mission.mcap
  rover replay runs/demo-1/mission.mcap --json | jq .first_difference
  rover replay runs/demo-1/mission.mcap --set gain_velocity=100000
  rover replay runs/demo-1/mission.mcap --override rover.cruise_speed_m_s=0.2
  rover replay runs/demo-1/mission.mcap --rate 1 --start 30 --pause
  rover replay runs/demo-1/mission.mcap --rig emulator
  rover replay runs/demo-1/mission.mcap --rig device --port /dev/ttyACM0
  rover replay --import my-recording/ --out my-recording.mcap
"""
DIFFERS = 6
# Seconds of the recording between two lines of progress.
LINE_PERIOD_S = 10.0


def command(
    log: Annotated[
        Path | None, typer.Argument(metavar="LOG", help="mission.mcap of a run, or an imported log.")
    ] = None,
    rig: Annotated[
        RigName, typer.Option(help="sitl: desktop process; emulator: emulated board; device: a real board.")
    ] = RigName.SITL,
    port: Annotated[str | None, typer.Option(metavar="P", help="Port of a real board.")] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="R", min=0.01, max=100.0, help="Real time, R times as fast; 1 is as it was.")
    ] = None,
    lock_step: Annotated[bool, typer.Option("--lock-step", help="As fast as it goes, in lock step; the default.")] = (
        False
    ),
    start: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="Seconds that are gone through without waiting.")
    ] = 0.0,
    pause: Annotated[bool, typer.Option("--pause", help="Stand still at the start until space or SIGUSR1.")] = False,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Change a firmware parameter (sitl).")
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--override", metavar="SECTION.KEY=VALUE", help="Change a value of the mission file."),
    ] = None,
    folder: Annotated[
        Path | None, typer.Option("--import", metavar="DIR", help="Make a log of a folder of frames and CSV files.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The log that --import writes.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress on stderr.")] = False,
) -> int:
    """See HELP."""
    if lock_step and rate is not None:
        raise BadInput("--lock-step and --rate: one of them")
    if rig is RigName.DEVICE and (lock_step or pause or rate not in (None, 1.0)):
        raise BadInput("--rig device: a board runs in real time, at rate 1 and without a pause")
    if (port is None) == (rig is RigName.DEVICE):
        raise BadInput("--rig device needs --port" if port is None else f"--port {port}: only with --rig device")
    if (log is None) == (folder is None):
        raise BadInput("name the log to replay, or with --import the folder to make one of")
    if folder is not None:
        return _import(folder, out, as_json)
    if out is not None:
        raise BadInput(f"--out {out}: only with --import")
    assert log is not None
    from rover_hil.parameter_file import parse_setting
    from rover_hil.replay.pace import Pace
    from rover_hil.replay.play import Changes, replay

    changes = Changes(
        dict(parse_setting(text) for text in settings or []), dict(_parse_override(text) for text in overrides or [])
    )
    pace = Pace(rate, start, pause)
    with pace.controlled():
        if pause and not quiet:
            say(f"paused; the space bar or kill -USR1 {os.getpid()} lets it go on")
        result = replay(log, rig.value, changes, pace, _progress(quiet), port)
    if as_json:
        write_json(document(result))
    else:
        write_text(text_of(result))
    return 0 if result.identical else DIFFERS


def document(result: Replayed) -> dict[str, Any]:
    """The contract's JSON, and what each part compared."""
    first = result.first_difference
    parts = {"firmware": result.firmware, "companion": result.companion}
    return {
        "log": str(result.log),
        "rig": result.rig,
        "frames": result.frames,
        "identical": result.identical,
        "first_difference": first.document() if first else None,
        "parts": {
            name: {
                "compared": part.count,
                "identical": part.difference is None,
                "first_difference": part.difference.document() if part.difference else None,
            }
            for name, part in parts.items()
            if part is not None
        },
        "build": result.build,
        "cut": result.cut,
    }


def text_of(result: Replayed) -> str:
    """A few lines for a person."""
    lines = [f"{result.frames} frames"]
    if result.firmware is not None:
        lines.append(
            f"firmware ({result.rig}): {result.firmware.count} {_unit(result)} {_word(result.firmware.difference)}"
        )
    lines.append(f"companion: {result.companion.count} messages {_word(result.companion.difference)}")
    lines += [f"built otherwise than when recorded: {key} {value}" for key, value in result.build.items()]
    if result.cut:
        lines.append("the log was cut short: compared up to where it ends")
    first = result.first_difference
    lines.append("identical" if first is None else f"first difference: {first}")
    return "\n".join(lines)


def _unit(result: Replayed) -> str:
    return "states and sums" if result.rig == RigName.DEVICE.value else "ticks"


def _word(difference: object) -> str:
    return "equal" if difference is None else "equal until the first difference"


def _import(folder: Path, out: Path | None, as_json: bool) -> int:
    from rover_hil.replay.imported import import_folder

    if out is None:
        raise BadInput("--import: name the log to write with --out")
    counts = import_folder(folder, out)
    if as_json:
        write_json({"log": str(out), **counts})
    else:
        write_text(", ".join(f"{count} {name}" for name, count in counts.items()) + f"\n{out}")
    return 0


def _parse_override(text: str) -> tuple[str, Any]:
    """`SECTION.KEY=VALUE`, the value as TOML, or as it stands. Raises BadInput."""
    from rover.toml_file import parse_value

    key, separator, value = text.partition("=")
    if not separator or "." not in key:
        raise BadInput(f"--override {text}: SECTION.KEY=VALUE is expected, as detector.standoff_m=0.6")
    return key, parse_value(value)


def _progress(quiet: bool) -> Any:
    due = LINE_PERIOD_S

    def tell(at: float) -> None:
        nonlocal due
        if at >= due and not quiet:
            due = at - at % LINE_PERIOD_S + LINE_PERIOD_S
            say(f"{at:.0f} s")

    return tell
