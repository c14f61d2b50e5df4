"""What an effect of a world file is: a switch, sizes with bounds, and where the sizes come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """One size of an effect; its unit is in the key's name. default: what the example has, a mild field's."""

    default: float
    low: float
    high: float
    meaning: str


@dataclass(frozen=True)
class Effect:
    """One table [group.name] of a world file. source: of its default sizes; "assumed" where nothing better is known."""

    meaning: str
    source: str
    sizes: Mapping[str, Size]
