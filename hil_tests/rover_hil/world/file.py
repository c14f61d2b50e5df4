"""Reads a world file: TOML with one table for each effect, off where it is not named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from rover.errors import BadInput
from rover.mission.config import Mission
from rover.toml_table import Table

from rover_hil.world.catalogue import EFFECTS

SHIPPED = Path(__file__).resolve().parent.parent / "worlds"
Sizes = Mapping[str, float]


@dataclass(frozen=True)
class World:
    """The effects that are on, "group.name" to their sizes. The default has none: a friendly world."""

    effects: Mapping[str, Sizes] = field(default_factory=dict)

    def sizes(self, effect: str) -> Sizes | None:
        """Of an effect of `EFFECTS` that is on; None where it is off."""
        if effect not in EFFECTS:
            raise KeyError(effect)
        return self.effects.get(effect)

    def alone(self, effect: str) -> World:
        """A world with nothing but that effect of this one."""
        return World({effect: self.effects[effect]})

    def text(self) -> str:
        """As a world file, without comments."""
        tables = (
            (name, "".join(f"{key} = {value!r}\n" for key, value in sizes.items()))
            for name, sizes in self.effects.items()
        )
        return "".join(f"[{name}]\n{sizes}" for name, sizes in tables)


FRIENDLY = World()


@lru_cache(maxsize=16)
def load_world(path: Path) -> World:
    """Reads and checks a world file. Raises BadInput with the key that is wrong."""
    top = Table.of_file(path)
    top.only(*{effect.partition(".")[0] for effect in EFFECTS})
    effects: dict[str, Sizes] = {}
    for group in top.names():
        table = top.table(group)
        known = {name.partition(".")[2]: name for name in EFFECTS if name.startswith(f"{group}.")}
        table.only(*known)
        for key in table.names():
            effect = EFFECTS[known[key]]
            own = table.table(key).only("on", *effect.sizes)
            sizes = {name: own.number(name, size.low, size.high, size.default) for name, size in effect.sizes.items()}
            if own.flag("on", True):
                effects[known[key]] = sizes
    return World(effects)


def find_world(name: str) -> Path:
    """The file of that path, or the one that ships under that name. Raises BadInput."""
    shipped = SHIPPED / f"{name}.toml"
    path = shipped if Path(name).suffix == "" and shipped.is_file() else Path(name)
    if not path.is_file():
        there = ", ".join(sorted(file.stem for file in SHIPPED.glob("*.toml")))
        raise BadInput(f"{name}: no such world file, and none that ships has that name: {there}")
    return path


def world_of(mission: Mission) -> World:
    """The world that a mission's [field] names. Raises BadInput."""
    name = mission.field.world
    return load_world(find_world(name)) if name else FRIENDLY
