"""The stage of a scripted drive: flat ground with posts on it, the rover without its camera, and the rig around it."""

from __future__ import annotations

import json
import math

import numpy as np
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD
from rover.link.port import SLCAN_BAUD, CanPort
from rover_plant import Plant

from rover_hil.client.bus import LockstepBus
from rover_hil.client.line import LockstepTransport
from rover_hil.scenario.board_faults import FAULTY_RIGS, FaultyRig
from rover_hil.scenario.catalogue import POST_HEIGHT_M
from rover_hil.scenario.faulty_wire import FaultyBus, FaultyLine, HostTime
from rover_hil.scenario.language import Scenario
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.wire_faults import WireFaults

RESOLUTION_M = 0.1
MARGIN_M = 1.0
# First exposure: after the end of any run.
NO_CAMERA_US = 10**15


def build_stage(scenario: Scenario) -> Plant:
    """The plant; the same scenario gives the same. Raises BadInput for what `[plant]` gets wrong."""
    field = scenario.field
    shape = (
        round((field.height + 2.0 * MARGIN_M) / RESOLUTION_M),
        round((field.width + 2.0 * MARGIN_M) / RESOLUTION_M),
    )
    x, y, heading = field.launch
    parts = {name: dict(values) for name, values in scenario.plant.items()}
    parts.setdefault("camera", {})["first_exposure_us"] = NO_CAMERA_US
    config = {
        "seed": scenario.seed,
        "raster_origin_x": -MARGIN_M,
        "raster_origin_y": -MARGIN_M,
        "raster_resolution": RESOLUTION_M,
        "area_width": field.width,
        "area_height": field.height,
        "launch": {"x": x, "y": y, "heading": math.radians(heading)},
        "baud": baud_of(scenario.transport),
        **parts,
    }
    obstacles = [[x, y, radius, POST_HEIGHT_M] for x, y, radius in field.obstacles]
    try:
        return Plant(
            json.dumps(config),
            np.full(shape, 300.0, dtype=np.float32),
            np.zeros(shape, dtype=np.float32),
            np.array(obstacles, dtype=np.float64).reshape(-1, 4),
        )
    except ValueError as error:
        raise BadInput(f"{scenario.path}: plant: {error}") from error


def baud_of(transport: str) -> int:
    """Bits per second of the port: what the host writes arrives at that rate."""
    return SLCAN_BAUD if transport == "can" else DEFAULT_BAUD


def build_rig(scenario: Scenario, rig: str, plant: Plant) -> FaultyRig:
    """The firmware, on the rig of that name. Raises BadInput, PreflightFailed."""
    if rig not in scenario.rigs:
        raise BadInput(f"{scenario.path}: rigs does not hold {rig}")
    if rig not in FAULTY_RIGS:
        raise BadInput(f"--rig {rig}: scenarios don't run there; there is {', '.join(FAULTY_RIGS)}")
    return FAULTY_RIGS[rig](plant, {}, baud_of(scenario.transport), scenario.transport)


def build_wire(
    scenario: Scenario, port: str, faults: WireFaults, probe: Probe, host: HostTime
) -> FaultyLine | FaultyBus:
    """The companion's end of the rig's port, with faults on it. Raises PreflightFailed."""
    if scenario.transport == "can":
        bus = LockstepBus(CanPort("slcan", port))
        return FaultyBus(bus, bus.announce, faults, probe, host)
    return FaultyLine(LockstepTransport(port, baud_of("serial")), faults, probe, host)
