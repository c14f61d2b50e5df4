"""From a mission, its ground and a camera to the plant: the configuration that rover_plant reads, and the plant."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from rover.errors import BadInput
from rover.mission.config import Mission
from rover.vehicle import Vehicle
from rover.vehicle.firmware import ORDERS, SENSORS, WIRING
from rover.vision.camera.model import CameraModel
from rover_plant import Plant

from rover_hil.ground import Ground
from rover_hil.world import World, world_of
from rover_hil.world.real_camera import bolometer, real_camera
from rover_hil.world.real_ground import slip_bursts, unevenness

CAMERA_PERIOD_US = 120_000
CAMERA_LATENCY_US = 60_000
# Later than any end of a mission.
NEVER_US = 10**18


def plant_config(mission: Mission, ground: Ground, camera: CameraModel, seed: int) -> dict[str, Any]:
    """Everything that differs from the plant's nominal rover; see hil_tests/plant/src/config.rs."""
    vehicle = mission.rover.vehicle
    launch = mission.launch
    world = world_of(mission)
    return {
        "seed": seed,
        "raster_origin_x": ground.origin_x,
        "raster_origin_y": ground.origin_y,
        "raster_resolution": ground.resolution,
        "area_width": mission.area.width,
        "area_height": mission.area.height,
        "launch": {
            "x": launch.pose.x,
            "y": launch.pose.y,
            "heading": launch.pose.heading,
            "surveyed_radius": launch.surveyed_radius,
        },
        "drive": {
            "track_width": vehicle.track_width,
            "wheel_radius": vehicle.wheel_radius,
            "wheel_radius_ratio": [1.0, vehicle.right_wheel_radius / vehicle.wheel_radius],
            "counts_per_revolution": vehicle.counts_per_revolution,
            **slip_bursts(world),
        },
        **unevenness(world),
        "wiring": wiring_config(vehicle),
        "sonar": {"mounts": [[mount.x, mount.y, mount.yaw] for mount in vehicle.sonars]},
        "inertial": {"fitted": mission.field.inertial_sensor},
        "camera": camera_config(camera, world, seed),
        "baud": mission.rover.baud,
        "footprint_radius": vehicle.radius,
    }


def wiring_config(vehicle: Vehicle) -> dict[str, Any]:
    """A rover whose wiring is what the vehicle's parameters put right."""
    values = vehicle.parameters()
    bits = {name: bool(values["wiring"] & bit) for name, bit in WIRING.items()}
    motors = [bits["left_motor_inverted"], bits["right_motor_inverted"]]
    return {
        "motors_inverted": motors,
        "encoders_inverted": [bits["left_encoder_inverted"], bits["right_encoder_inverted"]],
        "motors_swapped": bits["motors_swapped"],
        "encoders_swapped": bits["encoders_swapped"],
        "sonars": [SENSORS.index(sensor) for sensor in ORDERS[values["sonar_order"]]],
        "battery_scale": 1e6 / values["battery_scale"],
    }


def camera_config(camera: CameraModel, world: World, seed: int) -> dict[str, Any]:
    """The renderer's camera. Raises BadInput for one that it cannot draw."""
    if camera.skew:
        raise BadInput(f"camera {camera.name}: the simulated camera has no skew; set it to 0")
    camera = real_camera(camera, world, seed)
    lens = (*camera.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
    return {
        "width": camera.width,
        "height": camera.height,
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "mount_x": camera.x,
        "mount_y": camera.y,
        "mount_z": camera.z,
        "rotation": camera.base_from_camera.tolist(),
        "period_us": CAMERA_PERIOD_US,
        "latency_us": CAMERA_LATENCY_US,
        "lens": list(lens),
        "bolometer": bolometer(world),
    }


def describe_camera(camera: CameraModel) -> dict[str, Any]:
    """What the companion may know of a simulated camera: name, width, height, period_us, latency_us."""
    return {
        "name": camera.name,
        "width": camera.width,
        "height": camera.height,
        "period_us": CAMERA_PERIOD_US,
        "latency_us": CAMERA_LATENCY_US,
    }


def build_plant(mission: Mission, ground: Ground, camera: CameraModel, seed: int, pictures: bool = True) -> Plant:
    """The plant of a mission; the same arguments give the same bytes. Without `pictures` its camera takes none."""
    config = plant_config(mission, ground, camera, seed)
    if not pictures:
        config["camera"]["first_exposure_us"] = NEVER_US
    plant = Plant(
        json.dumps(config),
        np.ascontiguousarray(ground.temperature, dtype=np.float32),
        np.ascontiguousarray(ground.height, dtype=np.float32),
        np.asarray(ground.obstacles, dtype=np.float64).reshape(-1, 4),
    )
    for layer in ground.layers:
        plant.add_layer(np.ascontiguousarray(layer.raster, dtype=np.float32), layer.series)
    return plant
