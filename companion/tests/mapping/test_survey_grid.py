"""The map: what a frame shows becomes seen, obstacles become occupied and hide what is behind, echoes are believed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mapping import map_server
from rover.mapping.survey_grid import SurveyGrid
from rover.vehicle import Vehicle
from rover.vision.camera.file import load_camera

CAMERA = load_camera("lepton-160")
POSE = Pose2(0.3, 1.0, 0.0)
CENTRE_SONAR = Vehicle().sonars[1]


@dataclass(frozen=True)
class Spot:
    x: float
    y: float
    extent: float
    p: dict[str, float]


def spot(label: str, x: float = 0.6, y: float = 0.0, extent: float = 0.14) -> Spot:
    return Spot(x, y, extent, {name: float(name == label) for name in ("obstacle", "surface", "buried", "background")})


def frame(x: float = 0.6, y: float = 0.0, radius: float = 0.07, contrast: float = 8.0) -> Frame:
    """Soil at 300 K with one warm disc on the ground at (x, y) of base_link."""
    ground = CAMERA.ground_lookup
    noise = np.random.default_rng(1).normal(0, 0.05, ground.shape[:2])
    kelvin = 300.0 + noise + contrast * (np.hypot(ground[..., 0] - x, ground[..., 1] - y) < radius)
    return Frame((kelvin * 100).astype(np.uint16), 0.0, 0)


def cell(grid: SurveyGrid, x: float, y: float) -> tuple[int, int]:
    """Cell of a point in base_link at POSE."""
    return int((POSE.y + y) / grid.resolution), int((POSE.x + x) / grid.resolution)


def look(grid: SurveyGrid, *spots: Spot, times: int = 4, picture: Frame | None = None) -> None:
    for _ in range(times):
        grid.integrate_frame(picture or frame(), CAMERA, POSE, 0.01, list(spots))


def test_ground_in_view_is_seen_and_ground_behind_the_rover_is_not():
    grid = SurveyGrid(2.0, 2.0)
    look(grid, times=1)
    assert grid.seen[cell(grid, 0.5, 0.0)]
    assert not grid.seen[cell(grid, -0.1, 0.0)]
    assert not grid.seen[cell(grid, 1.3, 0.0)]


def test_seen_ground_is_the_view_polygon():
    grid = SurveyGrid(2.0, 2.0)
    look(grid, times=1)
    outline = POSE.transform(grid.view_polygon(CAMERA))
    x, y = outline.T
    area = 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))
    assert grid.seen.sum() * grid.resolution**2 == pytest.approx(area, rel=0.08)


def test_an_obstacle_is_occupied_and_what_it_hides_is_not_seen():
    grid = SurveyGrid(2.0, 2.0)
    look(grid, spot("obstacle"))
    assert grid.occupied[cell(grid, 0.6, 0.0)]
    assert not grid.seen[cell(grid, 0.6, 0.0)]
    assert not grid.seen[cell(grid, 0.85, 0.0)]
    assert grid.seen[cell(grid, 0.85, 0.3)]


@pytest.mark.parametrize("label", ["surface", "buried", "background"])
def test_a_warm_spot_that_is_no_obstacle_stays_free(label):
    grid = SurveyGrid(2.0, 2.0)
    look(grid, spot(label))
    assert not grid.occupied.any()
    assert grid.seen[cell(grid, 0.6, 0.0)]


def test_a_strong_anomaly_that_nothing_explains_is_occupied():
    grid = SurveyGrid(2.0, 2.0)
    look(grid)
    assert grid.occupied[cell(grid, 0.6, 0.0)]


def test_the_mosaic_is_the_mean_of_what_was_seen():
    grid = SurveyGrid(2.0, 2.0)
    look(grid, spot("surface"))
    assert grid.temperature[cell(grid, 0.6, 0.0)] == pytest.approx(308.0, abs=0.2)
    assert grid.temperature[cell(grid, 0.6, 0.3)] == pytest.approx(300.0, abs=0.2)
    assert np.isnan(grid.temperature[cell(grid, -0.2, 0.0)])


def test_close_echoes_make_an_obstacle_that_the_camera_cannot_free():
    grid = SurveyGrid(2.0, 2.0)
    for _ in range(6):
        grid.integrate_sonar(POSE, CENTRE_SONAR, 0.35)
    at = cell(grid, CENTRE_SONAR.x + 0.36, 0.0)
    assert grid.occupied[at]
    look(grid, times=10, picture=frame(contrast=0.0))
    assert grid.occupied[at]


def test_a_smear_of_a_far_echo_is_freed_by_plain_ground_in_the_picture():
    grid = SurveyGrid(2.0, 2.0)
    for _ in range(12):
        grid.integrate_sonar(POSE, CENTRE_SONAR, 0.65)
    at = cell(grid, CENTRE_SONAR.x + 0.66, 0.0)
    assert grid.occupied[at]
    look(grid, times=12, picture=frame(contrast=0.0))
    assert not grid.occupied[at]


def test_an_echo_is_an_arc_narrower_than_its_cone():
    grid = SurveyGrid(2.0, 2.0)
    for _ in range(6):
        grid.integrate_sonar(POSE, CENTRE_SONAR, 0.45)
    columns, rows = np.nonzero(grid.occupied.T)
    assert 0 < (rows.max() - rows.min() + 1) * grid.resolution < 2 * 0.45 * math.tan(CENTRE_SONAR.half_angle)
    assert (columns.max() - columns.min() + 1) * grid.resolution <= 0.08


def test_an_echo_beyond_80_cm_and_no_echo_occupy_nothing():
    grid = SurveyGrid(2.0, 2.0)
    for range_m in (0.9, None):
        for _ in range(20):
            grid.integrate_sonar(POSE, CENTRE_SONAR, range_m)
    assert not grid.occupied.any()


def test_free_ground_before_an_echo_is_freed():
    grid = SurveyGrid(2.0, 2.0)
    for _ in range(4):
        grid.integrate_sonar(POSE, CENTRE_SONAR, 0.35)
    for _ in range(30):
        grid.integrate_sonar(POSE, CENTRE_SONAR, None)
    assert not grid.occupied.any()


def test_a_rover_outside_the_area_changes_nothing():
    grid = SurveyGrid(1.0, 1.0)
    far = Pose2(30.0, 30.0, 0.0)
    grid.integrate_frame(frame(), CAMERA, far, 0.01, [])
    grid.integrate_sonar(far, CENTRE_SONAR, 0.3)
    assert not grid.seen.any()
    assert not grid.occupied.any()


def test_a_saved_map_reads_back(tmp_path):
    grid = SurveyGrid(2.0, 1.4)
    look(grid, spot("obstacle"))
    map_server.save(grid, tmp_path / "map.yaml")
    stored = map_server.read(tmp_path / "map.yaml")
    assert stored.resolution == grid.resolution
    assert (stored.occupied == grid.occupied).all()
    assert (stored.seen == (grid.seen | grid.occupied)).all()


def test_a_map_without_resolution_is_one_clear_line(tmp_path):
    (tmp_path / "map.yaml").write_text("image: map.pgm\norigin: [0, 0, 0]\n")
    with pytest.raises(BadInput, match=r"map\.yaml: resolution: missing"):
        map_server.read(tmp_path / "map.yaml")
