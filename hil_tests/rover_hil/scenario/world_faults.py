"""Faults of the rover's parts and of what stands in its way: of wheels, sonars, supply, camera, board and ground."""

from __future__ import annotations

import math

from rover.vehicle import STANDARD
from rover_plant import Plant

from rover_hil.scenario.board_faults import FaultyRig
from rover_hil.scenario.catalogue import SONARS, WHEELS
from rover_hil.scenario.language import Injection

OF_A_WHEEL = ("encoder-stuck", "encoder-reversed", "motor-stalled", "motor-open", "wheel-slip")
OF_A_SONAR = ("sonar-dead", "sonar-deaf", "sonar-near")
OF_THE_ROVER = ("bumper-pressed", "encoders-swapped", "camera-frozen", "camera-dead", "camera-ffc")
END_BY_THEMSELVES = ("firmware-hang", "firmware-stall", "brown-out", "encoder-jump", "obstacle-ahead", "carried-away")


class WorldFaults:
    """Puts them into a plant and a rig, and takes them out."""

    def __init__(self, plant: Plant, rig: FaultyRig) -> None:
        self._plant = plant
        self._rig = rig

    def switch(self, injection: Injection, on: bool) -> bool:
        """The fault begins or is over; False when it is not one of the world."""
        name, p = injection.fault, injection.parameters
        if name in OF_A_WHEEL:
            size = injection.number("share") if name == "wheel-slip" else 1.0
            self._plant.set_fault(name, WHEELS.index(str(p["wheel"])), size if on else 0.0)
        elif name in OF_A_SONAR:
            size = injection.number("range_m") if name == "sonar-near" else 1.0
            sensors = SONARS if p["sensor"] == "all" else (str(p["sensor"]),)
            for sensor in sensors:
                self._plant.set_fault(name, SONARS.index(sensor), size if on else 0.0)
        elif name in OF_THE_ROVER:
            self._plant.set_fault(name, 0, 1.0 if on else 0.0)
        elif name == "battery-sag":
            self._plant.set_fault("voltage-drop", 0, injection.number("drop_v") if on else 0.0)
        elif name == "can-interrupt-shorted":
            self._rig.short_interrupt(on)
        elif name == "emergency-stop-input":
            self._rig.set_emergency_stop(on)
        else:
            return self._board(injection, on)
        return True

    def _board(self, injection: Injection, on: bool) -> bool:
        name = injection.fault
        if name not in END_BY_THEMSELVES:
            return False
        if not on:
            return True
        if name == "firmware-hang":
            self._rig.hang()
        elif name == "firmware-stall":
            self._rig.stall(injection.duration or 0.06)
        elif name == "brown-out":
            self._rig.brown_out(injection.duration or 0.05)
        elif name == "encoder-jump":
            wheel = WHEELS.index(str(injection.parameters["wheel"]))
            self._plant.kick_encoder(wheel, int(injection.number("counts")))
        elif name == "carried-away":
            turn = math.radians(injection.number("turn_deg"))
            self._plant.carry(injection.number("ahead_m"), injection.number("left_m"), turn)
        else:
            self._obstacle(injection)
        return True

    def _obstacle(self, injection: Injection) -> None:
        x, y, heading = self._plant.pose()
        radius = injection.number("radius_m")
        bearing = heading + math.radians(injection.number("bearing_deg"))
        reach = STANDARD.radius + injection.number("distance_m") + radius
        at = x + reach * math.cos(bearing), y + reach * math.sin(bearing)
        self._plant.add_obstacle(*at, radius, injection.number("height_m"))
