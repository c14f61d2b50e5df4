"""Whoever stands beside the rover: a person who is asked, or the control socket of a simulated rig."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

WHEELS = ("left", "right")
SENSORS = ("left", "centre", "right")
BOX = "bring-up box"


@dataclass(frozen=True)
class Sight:
    """Where the rover stands: metres, radians; turns: of both wheels since it was set down, forward positive."""

    x: float
    y: float
    heading: float
    turns: tuple[float, float]


class Helper(Protocol):
    """What is asked. Every answer may raise BadInput."""

    def ready(self, text: str) -> None:
        """Something is to be done by hand; returns when it is."""
        ...

    def volts(self) -> float:
        """Battery voltage, by a meter at the battery's terminals."""
        ...

    def emergency(self, pressed: bool) -> None:
        """Press or release the emergency stop."""
        ...

    def before(self) -> Any:
        """Looks at the rover before a run; the result is handed back with a question about it."""
        ...

    def moved(self, before: Any) -> str:
        """Which wheel turned, and how: "left forward", "right back", ..., or "nothing"."""
        ...

    def turns(self, before: Any) -> tuple[float, float]:
        """By how much both wheels have turned, whole turns and parts of them, forward positive."""
        ...

    def straight(self, before: Any) -> tuple[float, float]:
        """How far the rover has come (metres), and by how much its heading has changed (radians)."""
        ...

    def rotation(self, before: Any, about: float) -> float:
        """By how much it has turned in all, radians, counter-clockwise positive; `about`: by its own reckoning."""
        ...

    def box(self, sensor: int, distance: float) -> None:
        """A box or a hand at that distance in front of a sensor, and of no other."""
        ...

    def no_box(self) -> None:
        """Takes it away."""
        ...


Ask = Callable[[dict[str, Any]], dict[str, Any]]


class RigHelper:
    """Asks a simulated rig; `ask` sends one request and returns its reply."""

    def __init__(self, ask: Ask, floor: tuple[float, float] | None = None) -> None:
        """`floor`: where the rover is put when it needs room, metres; without it where it stands now."""
        self._ask = ask
        self._boxed = False
        pose = ask({"op": "tape"})["rover"]
        self._floor = (pose["x"], pose["y"]) if floor is None else floor

    def ready(self, text: str) -> None:
        """Puts the rover back to where it has room."""
        self._ask({"op": "set_down", "x": self._floor[0], "y": self._floor[1], "heading_deg": 0.0})

    def volts(self) -> float:
        return float(self._ask({"op": "tape"})["battery_v"])

    def emergency(self, pressed: bool) -> None:
        if pressed:
            self._ask({"op": "fault", "fault": "emergency-stop-input", "name": "bring-up"})
        else:
            self._ask({"op": "fault", "end": "bring-up"})

    def before(self) -> Sight:
        told = self._ask({"op": "tape"})
        pose, turns = told["rover"], told["wheel_turns"]
        return Sight(pose["x"], pose["y"], math.radians(pose["heading_deg"]), (turns[0], turns[1]))

    def moved(self, before: Sight) -> str:
        turned = self.turns(before)
        wheel = max((0, 1), key=lambda number: abs(turned[number]))
        if abs(turned[wheel]) < 0.02:
            return "nothing"
        return f"{WHEELS[wheel]} {'forward' if turned[wheel] > 0.0 else 'back'}"

    def turns(self, before: Sight) -> tuple[float, float]:
        after = self.before()
        return after.turns[0] - before.turns[0], after.turns[1] - before.turns[1]

    def straight(self, before: Sight) -> tuple[float, float]:
        after = self.before()
        way = math.hypot(after.x - before.x, after.y - before.y)
        return way, math.remainder(after.heading - before.heading, 2.0 * math.pi)

    def rotation(self, before: Sight, about: float) -> float:
        turned = self.before().heading - before.heading
        return turned + 2.0 * math.pi * round((about - turned) / (2.0 * math.pi))

    def box(self, sensor: int, distance: float) -> None:
        self.no_box()
        self._ask({"op": "fault", "fault": "sonar-near", "sensor": SENSORS[sensor], "range_m": distance, "name": BOX})
        self._boxed = True

    def no_box(self) -> None:
        if self._boxed:
            self._ask({"op": "fault", "end": BOX})
            self._boxed = False
