"""The simulated thermal camera against the pinhole's geometry, and what its sensor adds."""

from __future__ import annotations

import math
import time
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.vision.camera.file import load_camera
from rover_hil.plant_config import camera_config
from rover_hil.testing.plants import QUIET_CAMERA, cell_centres, drive, make_plant
from rover_hil.world.file import FRIENDLY
from rover_plant import Plant

POSE = (1.7, 2.2, 0.6)
KELVIN_PER_X, KELVIN_PER_Y = 7.0, -4.0


def slope_temperature() -> NDArray[np.float64]:
    """A ground whose temperature tells the place: linear in x and y."""
    x, y = cell_centres()
    return 300.0 + KELVIN_PER_X * x + KELVIN_PER_Y * y


def pixel_rays(width: int, height: int, fx: float, fy: float) -> NDArray[np.float64]:
    """Directions (height * width, 3) in base_link of a camera pitched 52° down, worked out by hand here."""
    v, u = np.mgrid[0:height, 0:width]
    a, b = (u - (width - 1) / 2) / fx, (v - (height - 1) / 2) / fy
    sine, cosine = math.sin(math.radians(52.0)), math.cos(math.radians(52.0))
    forward, left, up = cosine - b * sine, -a, -sine - b * cosine
    return np.stack([forward, left, up], axis=-1).reshape(-1, 3)


@pytest.mark.parametrize(
    ("name", "width", "height", "hfov", "vfov"),
    [("lepton-160", 160, 120, 57.0, None), ("e6390-320", 320, 240, 45.0, 34.0)],
)
def test_each_pixel_sees_the_point_where_its_ray_meets_flat_ground(
    name: str, width: int, height: int, hfov: float, vfov: float | None
) -> None:
    fx = width / 2 / math.tan(math.radians(hfov) / 2)
    fy = fx if vfov is None else height / 2 / math.tan(math.radians(vfov) / 2)
    rays = pixel_rays(width, height, fx, fy)
    reach = 0.75 / -rays[:, 2]
    forward, left = rays[:, 0] * reach, rays[:, 1] * reach
    x0, y0, heading = POSE
    x = x0 + math.cos(heading) * forward - math.sin(heading) * left
    y = y0 + math.sin(heading) * forward + math.cos(heading) * left

    plant = make_plant(temperature=slope_temperature(), camera=camera_config(load_camera(name), FRIENDLY, 1))
    seen = plant.scene(*POSE)

    expected = 300.0 + KELVIN_PER_X * x + KELVIN_PER_Y * y
    # 5 mK are 0.7 mm on this ground.
    assert np.abs(seen - expected).max() < 0.005


def block_height() -> NDArray[np.float64]:
    """A post 0.15 m tall, 0.10 m in radius, 0.8 m ahead of (2, 2)."""
    x, y = cell_centres()
    return np.where(np.hypot(x - 2.8, y - 2.0) < 0.10, 0.15, 0.0)


def test_raised_ground_is_met_before_the_plane_below_it() -> None:
    plant = make_plant(temperature=slope_temperature(), height=np.full_like(block_height(), 0.10))
    rays = pixel_rays(160, 120, 80 / math.tan(math.radians(28.5)), 80 / math.tan(math.radians(28.5)))
    forward = rays[:, 0] * 0.65 / -rays[:, 2]
    left = rays[:, 1] * 0.65 / -rays[:, 2]
    expected = 300.0 + KELVIN_PER_X * (2.0 + forward) + KELVIN_PER_Y * (2.0 + left)
    assert np.abs(plant.scene(2.0, 2.0, 0.0) - expected).max() < 0.005


def test_a_post_hides_the_hot_ground_behind_it() -> None:
    x, y = cell_centres()
    hot_patch = np.where(np.hypot(x - 2.97, y - 2.0) < 0.04, 340.0, 300.0)
    open_view = make_plant(temperature=hot_patch).scene(2.0, 2.0, 0.0)
    blocked_view = make_plant(temperature=hot_patch, height=block_height()).scene(2.0, 2.0, 0.0)
    assert open_view.max() > 335.0
    assert blocked_view.max() < 301.0


def frames_of(plant: Plant) -> list[tuple[int, int, int, bool, NDArray[np.uint16]]]:
    return [
        (number, exposed, delivered, ffc, np.frombuffer(counts, dtype="<u2").reshape(120, 160))
        for number, exposed, delivered, ffc, counts in plant.take_frames()
    ]


def test_frames_come_every_120_ms_and_60_ms_late() -> None:
    plant = make_plant()
    drive(plant, 0.0, 0.0, 0.109)
    assert frames_of(plant) == []
    drive(plant, 0.0, 0.0, 0.001)
    drive(plant, 0.0, 0.0, 0.240)
    times = [(number, exposed, delivered) for number, exposed, delivered, *_ in frames_of(plant)]
    assert times == [(0, 50_000, 110_000), (1, 170_000, 230_000), (2, 290_000, 350_000)]


def test_counts_are_hundredths_of_a_kelvin() -> None:
    plant = make_plant(camera=QUIET_CAMERA)
    drive(plant, 0.0, 0.0, 0.2)
    assert (frames_of(plant)[0][4] == 30_000).all()


def test_a_frame_shows_the_pose_of_its_exposure() -> None:
    plant = make_plant(temperature=slope_temperature(), camera=QUIET_CAMERA, drive={"slip_bias": 0.0})
    poses = {}
    for _ in range(700):
        plant.step(0.6, 0.4, True)
        poses[plant.now_us] = plant.pose()
    for _, exposed, _, _, counts in frames_of(plant):
        ideal = plant.scene(*poses[exposed]).reshape(120, 160)
        assert np.abs(counts / 100.0 - ideal).max() < 0.006


def test_two_frames_of_one_scene_differ_by_50_mk_of_noise() -> None:
    plant = make_plant()
    drive(plant, 0.0, 0.0, 0.5)
    first, second = (frame[4].astype(float) / 100.0 for frame in frames_of(plant)[:2])
    assert (second - first).std() / math.sqrt(2.0) == pytest.approx(0.05, rel=0.05)


def test_corners_look_colder_than_the_centre() -> None:
    plant = make_plant(camera={**QUIET_CAMERA, "vignetting": 0.4})
    drive(plant, 0.0, 0.0, 0.2)
    kelvin = frames_of(plant)[0][4] / 100.0
    assert kelvin[60, 80] == pytest.approx(300.0, abs=0.02)
    assert kelvin[0, 0] == pytest.approx(299.6, abs=0.02)


def test_frames_during_a_calibration_are_flagged_and_frozen_and_leave_a_new_pattern() -> None:
    camera = {"netd": 0.0, "vignetting": 0.0, "ffc_first_us": 1_000_000, "ffc_period_us": 3_000_000}
    plant = make_plant(camera=camera)
    drive(plant, 0.0, 0.0, 5.5)
    frames = frames_of(plant)
    closed = [1_000_000, 4_000_000]
    for _, exposed, _, ffc, _ in frames:
        assert ffc == any(start <= exposed < start + 400_000 for start in closed)
    patterns = []
    for before, after in pairwise(frames):
        if after[3]:
            assert (after[4] == before[4]).all()
        elif before[3]:
            patterns.append(after[4].astype(float) - before[4])
    assert len(patterns) == 2
    for change in patterns:
        # Rows 30, columns 40 and pixels 30 mK, two independent draws of each.
        assert change.std() / 100.0 == pytest.approx(math.sqrt(2.0) * math.sqrt(0.03**2 + 0.04**2 + 0.03**2), rel=0.25)


def test_a_frame_takes_two_milliseconds_or_so() -> None:
    """Generous by a factor of five, because the machine may be busy: it guards against losing the tile walk."""
    plant = make_plant(temperature=slope_temperature(), height=block_height())
    start = time.process_time()
    for _ in range(20):
        plant.scene(2.0, 2.0, 0.0)
    assert (time.process_time() - start) / 20 < 0.010


def test_a_leaning_rover_sees_the_ground_that_its_turned_rays_meet() -> None:
    """Nose 0.05 rad down and left side 0.03 rad up: the rays turn, and the lens moves with the mast."""
    plant = make_plant(
        temperature=slope_temperature(), camera=camera_config(load_camera("lepton-160"), FRIENDLY, 1) | QUIET_CAMERA
    )
    plant.set_fault("pitched", 0, 0.05)
    plant.set_fault("rolled", 0, 0.03)
    assert plant.attitude() == (0.03, 0.05)
    cr, sr, cp, sp = math.cos(0.03), math.sin(0.03), math.cos(0.05), math.sin(0.05)
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rotation = pitch @ roll
    focal = 80 / math.tan(math.radians(28.5))
    rays = pixel_rays(160, 120, focal, focal) @ rotation.T
    lens = rotation @ np.array([0.0, 0.0, 0.75])
    reach = lens[2] / -rays[:, 2]
    x, y = 2.0 + lens[0] + rays[:, 0] * reach, 2.0 + lens[1] + rays[:, 1] * reach
    for _ in range(120):
        plant.step(0.0, 0.0, False)
    (frame,) = plant.take_frames()
    seen = np.frombuffer(frame[4], dtype="<u2") / 100.0
    inside = (x > -0.9) & (x < 4.9) & (y > -0.9) & (y < 4.9)
    expected = 300.0 + KELVIN_PER_X * x + KELVIN_PER_Y * y
    assert inside.mean() > 0.9
    assert np.abs(seen - expected)[inside].max() < 0.011
