"""`rover bringup`: from a box of parts to a rover that drives straight."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.connection import Baud, Port, connected
from rover.cli.output import say, write_json
from rover.errors import BadInput, PreflightFailed
from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.bringup.session import Done

HELP = """Bring a rover up: a guided sequence that measures it and writes what it finds into its vehicle file.

\b
Steps, in this order:
  supply     battery and divider, against a meter
  stop       the emergency stop, pressed and released
  wheels     motors and encoders: crossed, inverted, dead
  counts     counts of a wheel's turn
  sonars     which sensor is on which pins, at two distances
  geometry   both radii and the track, by straight runs and turns
  drive      feed-forward and dead band
  pid        gains of the speed loop, with their margins

The file is made when it is not there. A step that fails says what to mend; the next call goes on with it. Beside the
file lie a note of the steps that are done (.bringup.json) and a report (.bringup.html). At the end the board has the
file's values and keeps them. On a simulated rig, whose port rover hil serve has told, the rig answers every question.
The rover drives: first with its wheels in the air, then over 1.5 m of floor, and the guard is off meanwhile.

\b
Examples:
  rover bringup --port /dev/ttyACM0 --vehicle vehicle.toml
  rover bringup --port /dev/ttyACM0 --vehicle vehicle.toml --steps supply,stop,wheels
  rover bringup --port "$PORT" --vehicle vehicle.toml --yes --json        a simulated rig, without a question
"""


def command(
    port: Port,
    vehicle: Annotated[Path, typer.Option(metavar="FILE", help="Vehicle file; made when it is not there.")],
    steps: Annotated[
        str | None, typer.Option(metavar="STEP,…", help="These, whether they are done or not; else what is missing.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the rover moves for the first time.")] = False,
    voltmeter: Annotated[
        float | None, typer.Option(min=0.5, max=100.0, metavar="V", help="What a meter shows at the battery.")
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="Forget the steps that are done.")] = False,
    baud: Baud = DEFAULT_BAUD,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.bringup.helper import Helper, RigHelper
    from rover.bringup.rig_control import RigControl, control_of
    from rover.bringup.session import bring_up, chosen, load_notes, report_of
    from rover.cli.bringup_person import Person

    if not vehicle.resolve().parent.is_dir():
        raise BadInput(f"--vehicle {vehicle}: no such folder")
    made = [] if again else load_notes(vehicle)
    names = chosen(None if steps is None else [name for name in steps.split(",") if name], made)
    control = control_of(port)
    if not yes and control is None and not typer.confirm("the rover will drive; is somebody beside it?", err=True):
        raise BadInput("bringup: not without somebody beside the rover")
    rig = RigControl(control) if control is not None else None
    helper: Helper = Person(voltmeter) if rig is None else RigHelper(rig)
    with connected(port, baud) as link:
        results = bring_up(link, helper, vehicle, names, made, _tell)
    if rig is not None:
        rig.close()
    say(f"the vehicle is {vehicle}, the report {report_of(vehicle)}")
    if as_json:
        write_json({"steps": [done.as_dict() for done in results], "vehicle": str(vehicle)})
    return 0 if all(done.ok for done in results) else PreflightFailed.exit_code


def _tell(done: Done) -> None:
    say(f"{done.name:<9} {'well  ' if done.ok else 'FAILED'}  {done.message}")
