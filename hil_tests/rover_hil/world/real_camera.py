"""The camera as it is, from the one that its file describes and the effects of a world."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from rover.vision.camera.model import CameraModel

from rover_hil.world.file import World

# Of the stream of random numbers that draws what is fixed in a world.
STREAM = 101


def real_camera(camera: CameraModel, world: World, seed: int) -> CameraModel:
    """The camera as it is mounted and ground; the companion goes on believing in `camera`."""
    mount = world.sizes("camera.mount")
    if mount is not None:
        rng = np.random.default_rng([seed, STREAM])
        roll, pitch, yaw, height = rng.standard_normal(4) if mount["drawn"] else np.ones(4)
        camera = replace(
            camera,
            roll=camera.roll + roll * math.radians(mount["roll_deg"]),
            pitch=camera.pitch + pitch * math.radians(mount["pitch_deg"]),
            yaw=camera.yaw + yaw * math.radians(mount["yaw_deg"]),
            z=camera.z + height * mount["height_m"],
        )
    lens = world.sizes("camera.lens")
    if lens is not None:
        k1, k2, *others = (*camera.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
        camera = replace(camera, distortion=(k1 + lens["k1"], k2 + lens["k2"], *others))
    return camera


def bolometer(world: World) -> dict[str, Any]:
    """The plant's `camera.bolometer`; see hil_tests/plant/src/bolometer.rs."""
    told: dict[str, Any] = {}
    blur, delivery, clock = (world.sizes(f"camera.{name}") for name in ("blur", "delivery", "clock"))
    drift, shutter, dirt, glints = (world.sizes(f"camera.{name}") for name in ("drift", "shutter", "dirt", "glints"))
    if blur:
        told |= {"time_constant": 1e-3 * blur["time_constant_ms"]}
    if delivery:
        told |= {name: delivery[name] for name in ("dropped", "repeated", "late")}
        told |= {"jitter_us": 1e3 * delivery["jitter_ms"], "late_us": 1e3 * delivery["late_ms"]}
    if clock:
        told |= {"clock_offset_us": 1e3 * clock["offset_ms"], "clock_ppm": clock["drift_ppm"]}
    if drift:
        told |= {"drift": drift["level_k"], "drift_slope": drift["slope_k"], "drift_time": drift["time_constant_s"]}
    if shutter:
        told |= {
            "shutter_turning": shutter["turning_rad_s"],
            "shutter_us": round(1e6 * shutter["lasts_s"]),
            "shutter_rest_us": round(1e6 * shutter["rest_s"]),
        }
    if dirt:
        told |= {
            "dirt": round(dirt["spots"]),
            "drops_per_second": dirt["drops_per_min"] / 60.0,
            "drop_lasts": dirt["drop_lasts_s"],
            "spot_radius": dirt["radius_px"],
            "spot_transmission": dirt["transmission"],
            "window": dirt["window_k"],
        }
    if glints:
        told |= {
            "glints_per_second": glints["per_min"] / 60.0,
            "glint": glints["strength_k"],
            "glint_lasts": glints["lasts_s"],
        }
    return told
