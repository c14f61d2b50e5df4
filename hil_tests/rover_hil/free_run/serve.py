"""Sets up a rig for a mission, announces it, and lets it run until a client, a signal or a failure ends it."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

from rover.capture.publisher import FramePublisher
from rover.link.port import CanPort
from rover.mission.config import load
from rover.vehicle import load_vehicle
from rover.vision.camera.file import load_camera

from rover_hil.free_run.control import ControlSocket
from rover_hil.free_run.real_time import RealTime
from rover_hil.free_run.requests import Requests
from rover_hil.ground import build
from rover_hil.plant_config import build_plant, describe_camera
from rover_hil.scenario.board_faults import FAULTY_RIGS
from rover_hil.serve import check_rig, on_wire, share_one_core, verdict_of, write_truth
from rover_hil.world.file import find_world

# Between two steps of the world.
PERIOD_S = 0.002


@dataclass(frozen=True)
class Options:
    """What the command line says. `paused`: time stands still until a client says go.

    `vehicle`: how the rover is really built and wired; its board has the firmware's defaults.
    """

    mission: str
    rig: str = "sitl"
    transport: str = "serial"
    seed: int = 1
    paused: bool = False
    pictures: bool = True
    data: Path | None = None
    out: Path | None = None
    world: str = ""
    vehicle: Path | None = None


def serve(options: Options) -> None:
    """Runs the rig. Raises BadInput, PreflightFailed, RigFailed; SIGINT and SIGTERM end it in order."""
    check_rig(options.rig)  # before the field, which takes a while
    mission = on_wire(load(options.mission), options.transport)
    if options.world:
        find_world(options.world)  # one that is not there is told at once
        mission = replace(mission, field=replace(mission.field, world=options.world))
    if options.vehicle is not None:
        mission = replace(mission, rover=replace(mission.rover, vehicle=load_vehicle(options.vehicle)))
    ground = build(mission, options.seed, options.data)
    model = load_camera(mission.rover.camera)
    plant = build_plant(mission, ground, model, options.seed, options.pictures)
    share_one_core()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rover-rig-")))
        camera, control = folder / "camera.sock", folder / "control.sock"
        kind = FAULTY_RIGS[options.rig]
        described, baud = describe_camera(model), mission.rover.baud
        rig = stack.enter_context(closing(kind(plant, described, baud, options.transport, folder / "parameters")))
        world = RealTime(rig, stack.enter_context(closing(FramePublisher(camera))), options.paused)
        socket = stack.enter_context(closing(ControlSocket(control)))

        def judge(zones: list[dict[str, Any]], detections: list[dict[str, Any]]) -> dict[str, Any]:
            return verdict_of(rig, mission, ground, zones, detections)

        requests = Requests(rig, plant, world, options.transport, mission, judge)
        port = rig.port if options.transport == "serial" else CanPort("slcan", rig.port).name
        announce(port, f"socket:{camera}", control, folder / "rig.json")
        try:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, _end)
            while not requests.stopped:
                world.step()
                requests.end_faults()
                socket.serve(requests.answer, PERIOD_S)
        finally:
            if options.out is not None:
                write_truth(options.out, rig, ground, options.seed, judge([], []))


def announce(port: str, camera_source: str, control: Path, note: Path) -> None:
    """The first line of stdout, and a note for clients that know the port alone: what they need."""
    told = {"port": port, "camera_source": camera_source, "control": str(control), "pid": os.getpid()}
    note.write_text(json.dumps(told) + "\n", encoding="utf-8")
    sys.stdout.write(json.dumps(told) + "\n")
    sys.stdout.flush()


def _end(*_: object) -> NoReturn:
    raise SystemExit(0)
