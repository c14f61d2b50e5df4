"""`rover hil world`: the file that says how unfriendly the simulated world is, and pictures of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput

HELP = """Print a commented world file, say what a file switches on, or draw it.

A world file declares how unfriendly the simulated field, camera, weather and parts are; a mission names it with [field]
world = "world.toml", or one that ships: "mild", "hard", "brutal".

\b
Examples:
  rover hil world --example > world.toml
  rover hil world world.toml
  rover hil world hard --pictures hard/          a picture of every effect, alone, beside the friendly world
"""


def command(
    world: Annotated[
        str | None, typer.Argument(metavar="WORLD.toml", help="World file, or the name of one that ships.")
    ] = None,
    example: Annotated[bool, typer.Option("--example", help="Print a commented file that runs.")] = False,
    pictures: Annotated[Path | None, typer.Option(metavar="DIR", help="Draw every effect that is on.")] = None,
    mission: Annotated[str, typer.Option(metavar="MISSION", help="The field that is drawn.")] = "demo",
    seed: Annotated[int, typer.Option(min=0, help="Fixes the field and everything else random.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover_hil.world.catalogue import EFFECTS
    from rover_hil.world.example import example as example_file
    from rover_hil.world.file import find_world, load_world

    if example:
        if world is not None:
            raise BadInput("--example prints a file of its own: leave WORLD.toml out")
        write_text(example_file().rstrip("\n"))
        return 0
    if world is None:
        raise BadInput("name a world file, or give --example for one to begin with")
    loaded = load_world(find_world(world))
    drawn: list[str] = []
    if pictures is not None:
        from rover_hil.world.picture import draw

        pictures.mkdir(parents=True, exist_ok=True)
        for name in loaded.effects:
            file = pictures / f"{name}.png"
            draw(loaded.alone(name), name, mission, seed, file)
            drawn.append(str(file))
            say(f"rover: {file}")
    if as_json:
        effects = {name: dict(sizes) for name, sizes in loaded.effects.items()}
        write_json({"effects": effects, "pictures": drawn})
    else:
        lines = [
            f"{name}: {EFFECTS[name].meaning}\n    " + ", ".join(f"{key} {value:g}" for key, value in sizes.items())
            for name, sizes in loaded.effects.items()
        ]
        write_text("\n".join(lines) if lines else "no effect is on: a friendly world")
    return 0
