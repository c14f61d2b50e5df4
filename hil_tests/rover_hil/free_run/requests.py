"""What a client may ask of a rig that runs by itself, as docs/reference/simulation.md describes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission.config import Mission
from rover.toml_table import Table
from rover_plant import Plant

from rover_hil.free_run.real_time import RealTime
from rover_hil.scenario.board_faults import FaultyRig
from rover_hil.scenario.catalogue import FAULTS, OF_THE_WORLD
from rover_hil.scenario.language import Injection
from rover_hil.scenario.reading import read_fault
from rover_hil.scenario.world_faults import WorldFaults
from rover_hil.session import Finish

# Stands in messages where a scenario's file would.
WHERE = Path("request")

ROVER, LAUNCH = "rover", "launch"
MAX_M = 1000.0


@dataclass(frozen=True)
class _Active:
    """A fault that lasts until `end_us`, or until it is taken out."""

    injection: Injection
    end_us: float


class Requests:
    """Answers requests, and ends faults whose time is over. `stopped`: a client has asked for the end."""

    def __init__(
        self, rig: FaultyRig, plant: Plant, world: RealTime, transport: str, mission: Mission, judge: Finish
    ) -> None:
        self.stopped = False
        self._rig = rig
        self._plant = plant
        self._world = world
        self._transport = transport
        self._area, self._launch = mission.area, mission.launch.pose
        self._judge = judge
        self._faults = WorldFaults(plant, rig)
        self._active: dict[str, _Active] = {}
        self._answers: Mapping[str, Callable[[Table], dict[str, Any]]] = {
            "pause": self._pause,
            "go": self._go,
            "fault": self._fault,
            "set_down": self._set_down,
            "tape": self._tape,
            "motors": self._motors,
            "judge": self._verdict,
            "stop": self._stop,
        }

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        """One request. Raises BadInput, which is a ValueError, with one line."""
        if "op" not in request:
            raise BadInput(f"{WHERE}: op: missing; there is {', '.join(self._answers)}")
        operation = Table(WHERE, request).choice("op", tuple(self._answers))
        rest = {key: value for key, value in request.items() if key != "op"}
        reply = self._answers[operation](Table(WHERE, rest, operation))
        return {"time_s": self._rig.now_us * 1e-6, "paused": self._world.paused, **reply}

    def end_faults(self) -> None:
        """Takes out the faults whose time is over; to be called often."""
        for name in [name for name, active in self._active.items() if active.end_us <= self._rig.now_us]:
            self._take_out(name)

    def _pause(self, table: Table) -> dict[str, Any]:
        table.only()
        self._world.paused = True
        return {}

    def _go(self, table: Table) -> dict[str, Any]:
        table.only()
        self._world.paused = False
        return {}

    def _stop(self, table: Table) -> dict[str, Any]:
        table.only()
        self.stopped = True
        return {}

    def _fault(self, table: Table) -> dict[str, Any]:
        if table.has("end"):
            name = table.only("end").text("end")
            if name not in self._active:
                raise table.error("end", f"{name!r} is not active; there is {', '.join(self._active) or 'none'}")
            self._take_out(name)
            return {"faults": list(self._active)}
        injection = read_fault(table, OF_THE_WORLD, self._rig.name, self._transport)
        if injection.name in self._active:
            raise table.error("name", f"{injection.name!r} is there already: end it first, or give this one another")
        self._faults.switch(injection, True)
        if FAULTS[injection.fault].lasting:
            duration_us = math.inf if injection.duration is None else injection.duration * 1e6
            self._active[injection.name] = _Active(injection, self._rig.now_us + duration_us)
        return {"faults": list(self._active)}

    def _take_out(self, name: str) -> None:
        self._faults.switch(self._active.pop(name).injection, False)

    def _set_down(self, table: Table) -> dict[str, Any]:
        table.only("x", "y", "heading_deg")
        now = self._pose()
        x, y = table.number("x", 0.0, self._area.width), table.number("y", 0.0, self._area.height)
        heading = math.radians(table.number("heading_deg", -360.0, 360.0, math.degrees(now.heading)))
        dx, dy = x - now.x, y - now.y
        cosine, sine = math.cos(now.heading), math.sin(now.heading)
        self._plant.carry(cosine * dx + sine * dy, cosine * dy - sine * dx, heading - now.heading)
        return {"rover": self._whereabouts()}

    def _tape(self, table: Table) -> dict[str, Any]:
        table.only("from", "to")
        first, second = self._point(table, "from", LAUNCH), self._point(table, "to", ROVER)
        dx, dy = second[0] - first[0], second[1] - first[1]
        return {
            "distance_m": math.hypot(dx, dy),
            "bearing_deg": math.degrees(math.atan2(dy, dx)),
            "rover": self._whereabouts(),
            "wheel_turns": [angle / (2.0 * math.pi) for angle in self._plant.wheel_angles()],
            "battery_v": self._plant.battery()[0],
        }

    def _motors(self, table: Table) -> dict[str, Any]:
        table.only()
        left, right, powered = self._plant.duty()
        return {"powered": powered, "duty": [left, right]}

    def _verdict(self, table: Table) -> dict[str, Any]:
        table.only("zones", "detections")
        zones, detections = ([each.values for each in table.tables(key)] for key in ("zones", "detections"))
        try:
            return {"verdict": self._judge(zones, detections)}
        except (KeyError, TypeError) as error:
            raise BadInput(f"{WHERE}: judge: zones have t, id, x, y, r, detections class, x, y ({error})") from error

    def _point(self, table: Table, key: str, default: str) -> tuple[float, float]:
        """A point [x, y] of the field, or the name of one."""
        named = {ROVER: self._pose(), LAUNCH: self._launch}
        if not table.has(key) or table.holds_text(key):
            pose = named[table.choice(key, tuple(named), default)]
            return pose.x, pose.y
        x, y = table.row(key, ("x", "y"), -MAX_M, MAX_M)
        return x, y

    def _pose(self) -> Pose2:
        return Pose2(*self._plant.pose())

    def _whereabouts(self) -> dict[str, float]:
        pose = self._pose()
        return {"x": pose.x, "y": pose.y, "heading_deg": math.degrees(pose.heading)}
