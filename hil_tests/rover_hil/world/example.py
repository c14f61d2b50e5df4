"""A world file as text, from the catalogue: every effect with its switch, its sizes, and their source."""

from __future__ import annotations

from rover_hil.world.catalogue import EFFECTS
from rover_hil.world.effect import Effect

HEAD = """\
# A world file of the simulated rigs: how unfriendly the field, the rover's parts and people are.
# Name it in a mission: [field] world = "world.toml"; or serve it: rover hil serve MISSION --world world.toml.
# Every effect has a switch (on) and sizes; one that is left out, or switched off, is not there.
# With all of them off the world is the same, to the byte, as without a world file.
"""


def example(on: bool = True) -> str:
    """The commented file with every effect at its default sizes, switched on or off."""
    return HEAD + "".join(_table(name, effect, on) for name, effect in EFFECTS.items())


def _table(name: str, effect: Effect, on: bool) -> str:
    lines = [f"\n[{name}]", f"# {effect.meaning}", f"# Source: {effect.source}.", f"on = {str(on).lower()}"]
    settings = {key: f"{key} = {size.default:g}" for key, size in effect.sizes.items()}
    width = max(map(len, settings.values()))
    lines += [f"{settings[key]:<{width}}  # {size.meaning}" for key, size in effect.sizes.items()]
    return "\n".join(lines) + "\n"
