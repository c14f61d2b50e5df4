"""What the ground does to the rover that drives on it, for the plant."""

from __future__ import annotations

import math
from typing import Any

from rover_hil.world.file import World


def unevenness(world: World) -> dict[str, Any]:
    """The plant's `unevenness`; empty where the ground is level."""
    tilt = world.sizes("ground.tilt")
    if tilt is None:
        return {}
    return {"unevenness": {"tilt": math.radians(tilt["tilt_deg"]), "length": tilt["length_m"]}}


def slip_bursts(world: World) -> dict[str, Any]:
    """The plant's `drive.slip_bursts`; empty where wheels grip as on firm ground."""
    slip = world.sizes("ground.slip")
    if slip is None or slip["share"] == 0.0:
        return {}
    mean = min(slip["per_metre"] * slip["lasts_m"], 0.9) * slip["share"]
    return {"slip_bursts": {"mean": mean, "size": slip["share"], "length": slip["lasts_m"]}}
