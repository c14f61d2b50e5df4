"""A rig in this very process for tests of bring-up: a rover that is built otherwise than its board believes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rover.bringup.helper import RigHelper
from rover.link.session import Link
from rover.mission.config import load
from rover.vehicle import load_vehicle
from rover.vision.camera.file import load_camera
from rover_plant import Plant

from rover_hil.client.rig import open_lockstep
from rover_hil.free_run.real_time import RealTime
from rover_hil.free_run.requests import Requests
from rover_hil.ground import build
from rover_hil.plant_config import NEVER_US, describe_camera, plant_config
from rover_hil.scenario.board_faults import FaultyRig


class BenchRig:
    """Its firmware's time is that of the link: it moves when the companion waits. Is the link's Clock."""

    def __init__(
        self,
        vehicle: Path,
        memory: Path,
        seed: int = 1,
        *,
        exact: bool = False,
        broken: Mapping[str, Any] | None = None,
    ) -> None:
        """`exact`: wheels that do not slip, and motors that are alike. `broken`: of the plant's wiring."""
        read = load("bench")
        read = replace(read, rover=replace(read.rover, vehicle=load_vehicle(vehicle)))
        model = load_camera(read.rover.camera)
        ground = build(read, seed)
        config = plant_config(read, ground, model, seed)
        config["camera"]["first_exposure_us"] = NEVER_US
        config["wiring"] |= broken or {}
        if exact:
            config["drive"] |= {"slip_bias": 0.0, "slip_noise": 0.0, "motor_tolerance": 0.0}
        plant = Plant(json.dumps(config), ground.temperature, ground.height, np.zeros((0, 4)))
        self.plant = plant
        self.rig = FaultyRig(plant, describe_camera(model), read.rover.baud, "serial", memory)
        world = RealTime(self.rig, paused=True)
        self._requests = Requests(self.rig, plant, world, "serial", read, lambda *_: {})
        wire, self._announce = open_lockstep(self.rig.port, read.rover.baud, lead=0.0)
        self.rig.begin_session()
        self.link = Link(wire, self, session=seed)
        self.helper = RigHelper(self.ask)

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """What the control socket of a served rig would answer."""
        return {"ok": True, **self._requests.answer(request)}

    def now(self) -> float:
        """Seconds of virtual time."""
        return self.rig.now_us * 1e-6

    def advance(self, to: float) -> None:
        """Lets the world run until then."""
        step = self.rig.advance(round(to * 1e6), self.link.wire.transport.bytes_written)
        self._announce(list(step.marks))
        self._requests.end_faults()

    def close(self) -> None:
        """Ends the firmware."""
        self.link.close()
        self.rig.close()
