"""`rover hil serve`: a rig by itself, for any client."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rover.errors import BadInput
from rover.link.rig import RigName, TransportName

HELP = """Run a rig by itself: firmware, field and camera in real time, for any client.

The first line of stdout is JSON: `port` and `camera_source`, as other commands take them, `control` and `pid`.
`control` is a unix socket that takes one JSON object a line and answers with one: pause, go, fault, set_down, tape,
judge, stop; docs/reference/simulation.md describes them. Without --free-run time stands still until a client says go.

\b
Examples:
  rover hil serve demo --free-run
  rover hil serve demo --world hard
  rover hil serve field.toml --seed 7 --transport can
  echo '{"op": "fault", "fault": "battery-sag", "drop_v": 2.0}' | nc -U CONTROL
"""


def command(
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="Mission file, or the name of a shipped one.")],
    rig: Annotated[RigName, typer.Option(help="sitl: desktop process; emulator: emulated board.")] = RigName.SITL,
    transport: Annotated[TransportName, typer.Option(help="The wire to the firmware.")] = TransportName.SERIAL,
    seed: Annotated[int, typer.Option(min=0, help="Fixes the field and everything else random.")] = 1,
    free_run: Annotated[bool, typer.Option("--free-run", help="Time runs from the start.")] = False,
    no_camera: Annotated[bool, typer.Option("--no-camera", help="The camera takes no pictures.")] = False,
    world: Annotated[
        str, typer.Option(metavar="WORLD.toml", help="How unfriendly it is: a file, or the name of one that ships.")
    ] = "",
    data: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder with landmines/: ground of real thermal pictures.")
    ] = None,
    vehicle: Annotated[
        Path | None, typer.Option(metavar="V.toml", help="How the rover is really built and wired.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for truth.tum and truth.json.")] = None,
) -> int:
    """See HELP."""
    if rig is RigName.DEVICE:
        raise BadInput("--rig device: a real board is there already; serve is for the simulated ones")
    if data is not None and not data.is_dir():
        raise BadInput(f"--data {data}: no such folder")
    from rover_hil.free_run.serve import Options, serve

    serve(Options(mission, rig.value, transport.value, seed, not free_run, not no_camera, data, out, world, vehicle))
    return 0
