"""Parallax on frames of the simulated camera: a low tuft stands out, and nothing that is flat."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.parallax import LEAST_VIEWS, VIEW_STEP, Parallax
from rover.mapping.rectangle import Rectangle
from rover.vision.camera.file import load_camera
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import soil_named
from rover_hil.ground.texture import soil_texture
from rover_hil.ground.things import at_hour, lay_grass
from rover_hil.testing.plants import NO_SLIP, ORIGIN_M, RESOLUTION_M, SAME_MOTORS, SIDE_CELLS, drive, make_plant
from rover_plant import Plant

TUFT = (3.1, 2.05, 0.11, 0.086)
GRID = Grid(ORIGIN_M, ORIGIN_M, RESOLUTION_M, SIDE_CELLS, SIDE_CELLS)
STRAIGHT = {**NO_SLIP, **SAME_MOTORS}
CAMERA = load_camera("lepton-160")
Raster = NDArray[np.float32]


class Watched(Parallax):
    """With all that was judged, over 5 x 4 m."""

    def __init__(self) -> None:
        super().__init__(0.02)
        self.standing = np.zeros((200, 250), bool)

    def take(self, frame: Frame, pose: Pose2, mines: Sequence[tuple[float, float]] = ()) -> None:
        found = self.integrate(frame, CAMERA, pose, mines, 0.15)
        if found is not None:
            at = found.where.slices(Rectangle(0, 0, 200, 250))
            self.standing[at][found.judged] = found.standing[found.judged]


def ground(seed: int, tuft: bool = True, tall: bool = True) -> tuple[Raster, Raster]:
    """Loam at 13:00 with a tuft; `tall` False: only its picture lies there."""
    rng = np.random.default_rng(seed)
    now = at_hour(soil_named("loam"), 13.0)
    kelvin, height = soil_texture(GRID, rng) + np.float32(now.soil), np.zeros(GRID.shape, np.float32)
    if tuft:
        lay_grass(kelvin, height, GRID, TUFT, now, rng)
    return kelvin, height if tall else np.zeros_like(height)


def look(parallax: Watched, plant: Plant) -> Pose2:
    """All frames that are there, laid by the true pose."""
    truth = plant.truth()
    for sequence, exposure_us, _, ffc, counts in plant.take_frames():
        if not ffc:
            x, y, heading = (float(np.interp(exposure_us * 1e-6, truth[:, 0], truth[:, i])) for i in (1, 2, 3))
            picture = np.frombuffer(counts, np.uint16).reshape(120, 160)
            parallax.take(Frame(picture, exposure_us * 1e-6, sequence), Pose2(x, y, heading))
    x, y, heading = plant.pose()
    return Pose2(x, y, heading)


def driven(kelvin: Raster, height: Raster, metres: float) -> tuple[Watched, Pose2]:
    """Straight ahead at 0.2 m/s or so."""
    plant = make_plant(kelvin, height, drive=STRAIGHT)
    parallax = Watched()
    pose = look(parallax, plant)
    while pose.x < 2.0 + metres:
        drive(plant, 0.3, 0.3, 0.12)
        pose = look(parallax, plant)
    return parallax, pose


def share(parallax: Watched) -> float:
    """Of the tuft's cells, those that stand."""
    y, x = (np.mgrid[:200, :250] + 0.5) * 0.02
    return float(parallax.standing[np.hypot(x - TUFT[0], y - TUFT[1]) < TUFT[2]].mean())


def far(parallax: Watched) -> float:
    """m² that stand more than 15 cm from the tuft."""
    y, x = (np.mgrid[:200, :250] + 0.5) * 0.02
    return float(parallax.standing[np.hypot(x - TUFT[0], y - TUFT[1]) > TUFT[2] + 0.15].sum()) * 4e-4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_tuft_of_8_6_cm_is_seen_before_the_hull_is_near(seed: int) -> None:
    parallax, pose = driven(*ground(seed), 0.65)
    assert TUFT[0] - TUFT[2] - 0.15 - pose.x > 0.12
    assert share(parallax) > 0.25
    assert far(parallax) < 0.002


def test_the_same_picture_on_flat_ground_is_flat() -> None:
    parallax, _ = driven(*ground(1, tall=False), 0.65)
    assert share(parallax) == 0.0
    assert far(parallax) < 0.002


def test_near_a_mine_nothing_is_said_to_stand() -> None:
    parallax = Watched()
    rng = np.random.default_rng(1)
    for step in range(12):
        noisy = rng.integers(30_000, 30_200, (120, 160)).astype(np.uint16)
        pose = Pose2(2.0 + 0.05 * step, 2.0, 0.0)
        parallax.take(Frame(noisy, 0.1 * step, step), pose, [(3.0, 2.0)])
    y, x = (np.mgrid[:200, :250] + 0.5) * 0.02
    assert not parallax.standing[np.hypot(x - 3.0, y - 2.0) < 0.15].any()


def test_ground_is_judged_by_views_from_several_places_and_never_by_turning() -> None:
    kelvin, height = ground(4, tuft=False)
    plant = make_plant(kelvin, height, drive=STRAIGHT)
    parallax = Watched()
    for _ in range(20):
        drive(plant, -0.3, 0.3, 0.2)
        look(parallax, plant)
    assert math.hypot(plant.pose()[0] - 2.0, plant.pose()[1] - 2.0) < VIEW_STEP
    assert not any(parallax.is_judged(2.0 + 0.6 * math.cos(a), 2.0 + 0.6 * math.sin(a), 0.15) for a in (0.0, 1.5, 3.0))
    parallax, pose = driven(kelvin, height, LEAST_VIEWS * VIEW_STEP + 0.1)
    assert parallax.is_judged(pose.x + 0.5, pose.y, 0.15)
    assert not parallax.is_judged(pose.x, pose.y, 0.15), "the camera does not see the ground under the hull"
    parallax.bear(pose.x, pose.y, 0.17)
    assert parallax.is_judged(pose.x, pose.y, 0.15), "but the hull has been there"


def test_ground_without_texture_is_not_judged() -> None:
    even = np.full(GRID.shape, 300.0, np.float32)
    parallax, pose = driven(even, np.zeros_like(even), 0.4)
    assert not parallax.standing.any()
    assert not parallax.is_judged(pose.x + 0.5, pose.y, 0.15)
