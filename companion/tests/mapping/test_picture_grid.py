"""Specification: thermal and visible pictures each give a binary grid on the ground plane (paper, figure 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mapping import map_server
from rover.mapping.picture_grid import PictureGrid
from rover.mapping.thermal_anomaly import anomalies
from rover.mapping.visible_anomaly import visible_anomalies
from rover.vision.camera.file import load_camera

CAMERA = load_camera("lepton-160")
POSE = Pose2(0.3, 1.0, 0.0)
STONE = (0.6, 0.1)


def on_ground(inside: float, outside: float, noise: float, tilt: float = 0.0) -> np.ndarray:
    """A picture of plain ground with one disc of 14 cm at STONE of base_link; tilt: change from left to right."""
    ground = CAMERA.ground_lookup
    far = np.hypot(ground[..., 0] - STONE[0], ground[..., 1] - STONE[1]) < 0.07
    plain = outside + np.linspace(0.0, tilt, CAMERA.width)[None, :]
    shown: np.ndarray = np.where(far, inside, plain) + np.random.default_rng(1).normal(0.0, noise, far.shape)
    return shown


def cell(grid: PictureGrid, x: float, y: float) -> tuple[int, int]:
    return int((POSE.y + y) / grid.resolution), int((POSE.x + x) / grid.resolution)


def thermal() -> np.ndarray:
    return anomalies(on_ground(306.0, 300.0, 0.05).astype(np.float32))[0]


def visible() -> np.ndarray:
    return visible_anomalies(on_ground(190.0, 100.0, 3.0, tilt=40.0))


@pytest.mark.parametrize("picture", [thermal, visible])
def test_a_stone_is_occupied_and_ground_around_is_free(picture) -> None:
    grid = PictureGrid(2.0, 2.0)
    for _ in range(3):
        grid.integrate(picture(), CAMERA, POSE)
    assert grid.occupied[cell(grid, *STONE)]
    assert not grid.occupied[cell(grid, 0.6, -0.2)]
    assert grid.seen[cell(grid, 0.6, -0.2)]
    assert not grid.seen[cell(grid, -0.2, 0.0)]
    share = grid.occupied[grid.seen].mean()
    assert 0.0 < share < 0.1


def test_what_is_no_longer_shown_is_freed_again() -> None:
    grid = PictureGrid(2.0, 2.0)
    for _ in range(3):
        grid.integrate(thermal(), CAMERA, POSE)
    for _ in range(4):
        grid.integrate(np.zeros((CAMERA.height, CAMERA.width), bool), CAMERA, POSE)
    assert not grid.occupied.any()


def test_a_picture_of_another_camera_is_one_clear_line() -> None:
    with pytest.raises(BadInput, match="320x240 pixels, but camera lepton-160 has 160x120"):
        PictureGrid(1.0, 1.0).integrate(np.zeros((240, 320), bool), CAMERA, POSE)


def test_a_picture_grid_is_saved_and_read(tmp_path: Path) -> None:
    grid = PictureGrid(2.0, 1.4)
    grid.integrate(thermal(), CAMERA, POSE)
    map_server.save(grid, tmp_path / "thermal.yaml")
    stored = map_server.read(tmp_path / "thermal.yaml")
    assert (stored.occupied == grid.occupied).all()
    assert (stored.seen == grid.seen).all()


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("resolution: inf", "resolution"),
        ("resolution: nan", "resolution"),
        ("resolution: -0.02", "resolution"),
        ("origin: [nan, 0, 0]", "origin"),
        ("origin: [0, inf, 0]", "origin"),
        ("occupied_thresh: nan", "occupied_thresh"),
        ("free_thresh: inf", "free_thresh"),
    ],
)
def test_numbers_that_are_none_are_refused(tmp_path: Path, line: str, key: str) -> None:
    map_server.save(PictureGrid(1.0, 1.0), tmp_path / "map.yaml")
    lines = (tmp_path / "map.yaml").read_text().splitlines()
    spoiled = [line if old.startswith(f"{key}:") else old for old in lines]
    (tmp_path / "map.yaml").write_text("\n".join(spoiled))
    with pytest.raises(BadInput, match=rf"map\.yaml: {key}: "):
        map_server.read(tmp_path / "map.yaml")
