"""The parts of a scenario, as `reading.py` takes them out of TOML and `runner.py` plays them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rover_hil.scenario.condition import Condition

# The moment at which the rover has been armed, or is ready when the scenario does not arm.
START = "start"

ParameterValue = float | str | bool | tuple[int, ...] | tuple[str, ...] | dict[str, int]


@dataclass(frozen=True)
class Move:
    """One leg of a scripted drive: metres forward, degrees to the left, or seconds of standing."""

    kind: str
    amount: float


@dataclass(frozen=True)
class Drive:
    """What the companion drives. `moves` are as written, `repeat` included."""

    moves: tuple[Move, ...] = ()
    speed: float = 0.25
    arm: bool = True
    disarm: bool = False


@dataclass(frozen=True)
class Injection:
    """A fault: at a time after START, when a condition becomes true, or before the companion connects."""

    name: str
    fault: str
    at: float | None
    when: Condition | None
    when_text: str
    after: str | None
    duration: float | None
    parameters: Mapping[str, ParameterValue]

    def number(self, name: str) -> float:
        """A parameter that is a number."""
        value = self.parameters[name]
        assert isinstance(value, (int, float)), f"{self.fault}: {name} is no number"
        return float(value)

    @property
    def from_boot(self) -> bool:
        """There from the moment that the rover is switched on."""
        return self.at is None and self.when is None and self.after is None


@dataclass(frozen=True)
class Check:
    """A condition in the words of the file, with its meaning. `moved_below`: metres since the reference event."""

    text: str
    condition: Condition
    moved_below: float | None = None


@dataclass(frozen=True)
class Expectation:
    """Must come true within `within` seconds after the event `after`, and not before `not_before`.

    What is the case before `begin` seconds is not looked at.
    """

    name: str
    after: str
    within: float
    not_before: float
    begin: float
    checks: tuple[Check, ...]


@dataclass(frozen=True)
class Prohibition:
    """Must never be true from the event `after` on, until the event `until` if there is one."""

    name: str
    after: str
    until: str | None
    check: Check


@dataclass(frozen=True)
class Field:
    """The ground: a rectangle with discs on it, [x, y, radius] in metres. Launch: x, y, heading in degrees."""

    width: float = 4.0
    height: float = 4.0
    launch: tuple[float, float, float] = (1.0, 2.0, 0.0)
    obstacles: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Scenario:
    """One file."""

    path: Path
    name: str
    description: str
    rigs: tuple[str, ...]
    seed: int
    transport: str
    max_duration: float
    settle: float
    field: Field
    drive: Drive
    parameters: Mapping[str, int]
    injections: tuple[Injection, ...]
    expectations: tuple[Expectation, ...]
    prohibitions: tuple[Prohibition, ...]
    end: tuple[Check, ...]
    mission: str | None = None
    plant: Mapping[str, Mapping[str, float]] = dataclasses.field(default_factory=dict)
