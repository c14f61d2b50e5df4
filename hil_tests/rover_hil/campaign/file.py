"""The campaign file: which mission, how many of it, and what is drawn for each. See EXAMPLE."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.mission.config import SECTIONS, load
from rover.toml_table import Table

EXAMPLE = """\
# A campaign: many missions, each with its own seed and with values drawn from the distributions below.
# Run it:      rover campaign this-file.toml --out campaigns/first
# Go on:       rover campaign this-file.toml --out campaigns/first --continue

[campaign]
name = "demo field, friendly to hard"
mission = "demo"         # a mission file beside this one, or one that ships
missions = 16            # Sobol sequences are balanced for powers of two
seed = 1                 # of the draw; each mission has a seed of its own
sampling = "sobol"       # or "random"
keep = ["failed", "worst"]   # folders that stay: also "all", or [] for none; every mission has its row
worst_share = 0.1        # how much of all is "worst"
time_limit_s = 1800      # of this computer's clock; a mission that takes longer is a failure
strata = ["field.world"] # every rate is told for each of these values, too

[draw]                   # keys of a mission file, each with one of choice, uniform, integer
"field.world" = { choice = ["mild", "hard"] }
"field.rocks" = { integer = [2, 6] }
"mission.time_of_day" = { choice = ["10:00", "13:00", "16:00"] }
"area.width_m" = { uniform = [2.5, 3.5] }
"""

KEEP = ("failed", "worst", "all")
MAX_MISSIONS = 100_000


@dataclass(frozen=True)
class Distribution:
    """Of one key of the mission file. choices: equally likely; or low to high, whole numbers with both ends."""

    key: str
    choices: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    whole: bool = False

    def at(self, u: float) -> Any:
        """The value at the quantile `u`, 0 to below 1."""
        if self.choices:
            return self.choices[int(u * len(self.choices))]
        if self.whole:
            return int(self.low) + int(u * (int(self.high) - int(self.low) + 1))
        return round(self.low + u * (self.high - self.low), 4)


@dataclass(frozen=True)
class Campaign:
    """A whole file. document: of the mission that is varied, as its file says."""

    path: Path
    name: str
    mission: Path
    missions: int
    seed: int
    sampling: str
    keep: tuple[str, ...]
    worst_share: float
    time_limit_s: float
    strata: tuple[str, ...]
    draw: tuple[Distribution, ...]


def load_campaign(path: Path) -> Campaign:
    """Raises BadInput for anything wrong in the file, and in the mission that it names."""
    top = Table.of_file(path).only("campaign", "draw")
    head = top.table("campaign").only(
        *("name", "mission", "missions", "seed", "sampling", "keep", "worst_share", "time_limit_s", "strata")
    )
    named = head.text("mission", "demo")
    beside = path.parent / named
    mission = load(beside if beside.is_file() else named)
    draw = tuple(_distribution(top.table("draw"), key) for key in top.table("draw").names())
    keys = tuple(each.key for each in draw)
    strata = head.choices("strata", keys) if head.values.get("strata") else ()
    keep = () if head.has("keep") and head.values["keep"] == [] else head.choices("keep", KEEP, KEEP[:2])
    return Campaign(
        path=path,
        name=head.text("name", path.stem),
        mission=mission.path,
        missions=head.integer("missions", 1, MAX_MISSIONS, 16),
        seed=head.integer("seed", 0, 2**31 - 1, 1),
        sampling=head.choice("sampling", ("sobol", "random"), "sobol"),
        keep=keep,
        worst_share=head.number("worst_share", 0.0, 1.0, 0.1),
        time_limit_s=head.number("time_limit_s", 1.0, 1e6, 1800.0),
        strata=strata,
        draw=draw,
    )


def _distribution(draw: Table, key: str) -> Distribution:
    section, _, name = key.partition(".")
    if section not in SECTIONS or name not in SECTIONS[section]:
        raise draw.error(key, "is no key of a mission file, such as field.rocks")
    table = draw.table(key).only("choice", "uniform", "integer")
    if len(table.names()) != 1:
        raise draw.error(key, "takes one of choice, uniform and integer")
    if table.has("choice"):
        choices = table.values["choice"]
        if not isinstance(choices, list) or not choices:
            raise draw.error(key, "choice must be a list of values")
        return Distribution(key, choices=tuple(choices))
    kind = "uniform" if table.has("uniform") else "integer"
    low, high = table.row(kind, ("low", "high"), -1e6, 1e6)
    if low > high:
        raise draw.error(key, f"{low:g} lies above {high:g}")
    if kind == "integer" and (low != int(low) or high != int(high)):
        raise draw.error(key, "integer takes whole numbers")
    return Distribution(key, low=low, high=high, whole=kind == "integer")


def example() -> str:
    """A commented file that runs."""
    return EXAMPLE
