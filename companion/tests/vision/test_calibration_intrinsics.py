"""A camera is found again from pictures of a board; views that do not determine it are refused.

Pictures are synthetic: every ray is traced through the true camera onto the board, then blur and noise.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from rover.errors import BadInput
from rover.vision.calibration.board import Board, find_board
from rover.vision.calibration.box import calibrate_box, find_box
from rover.vision.calibration.file import camera_toml
from rover.vision.calibration.intrinsics import Freedom, calibrate, project
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

from companion.tests.vision.calibration_scene import (
    box,
    checkerboard,
    circle_grid,
    pose,
    render,
    staggered_grid,
    tilted_poses,
)

LENS = (-0.2, 0.06, 0.001, -0.0005)
LEPTON = CameraModel("truth", 160, 120, 150.0, 151.5, 80.8, 58.6, 0.0, LENS)
CHECKS = Board(8, 5, 0.04)
CIRCLES = Board(7, 5, 0.05, circles=True)
# OpenCV's asymmetric grid: eleven rows of four.
STAGGERED = Board(4, 11, 0.02, circles=True, staggered=True)
WIDE = CameraModel("wide", 320, 240, 300.0, 300.0, 160.2, 119.1)


def exact_views(camera, board, poses, noise=0.05, seed=0):
    rng = np.random.default_rng(seed)
    views = [project(camera, (board.points @ r.T + t)[None])[0] for r, t in poses]
    return [view + noise * rng.standard_normal(view.shape) for view in views]


@pytest.mark.slow
@pytest.mark.parametrize("board", [CHECKS, CIRCLES], ids=["checkerboard", "circles"])
def test_a_lepton_is_found_again_from_noisy_pictures_of_both_polarities(board):
    """0.16 K of noise on 8 K of contrast, half of the boards cold, pixels of 16 and 8 bits."""
    rng = np.random.default_rng(1)
    paint = circle_grid(board) if board.circles else checkerboard(board)
    views = []
    for number, where in enumerate(tilted_poses(board, LEPTON, 10, rng)):
        picture = render(LEPTON, paint, where, rng, hot=number % 2 == 0, bits=16 if number % 3 else 8)
        found = find_board(picture, board)
        assert found is not None
        truth = project(LEPTON, (board.points @ where[0].T + where[1])[None])[0]
        order = min((found, found[::-1]), key=lambda points: np.abs(points - truth).max())
        assert np.sqrt(((order - truth) ** 2).sum(axis=1).mean()) < 0.1
        views.append(found)
    result = calibrate(board.points, views, (160, 120), Freedom())
    found = result.camera
    assert found.fx == pytest.approx(LEPTON.fx, rel=0.005)
    assert found.fy == pytest.approx(LEPTON.fy, rel=0.005)
    assert np.hypot(found.cx - LEPTON.cx, found.cy - LEPTON.cy) < 1.0
    grid = np.array([[u, v] for u in (8.0, 80.0, 151.0) for v in (8.0, 60.0, 111.0)])
    off = found.normalized_to_pixel(LEPTON.pixel_to_normalized(grid)) - grid
    assert np.linalg.norm(off - off.mean(axis=0), axis=1).max() < 0.5, "the lens too, out to the corners"
    assert result.rms < 0.15


def staggered_views(count: int):
    """A staggered board that fills the picture's height, tilted to every side, hot and cold, with its truth."""
    rng = np.random.default_rng(11)
    middle = tuple((STAGGERED.points[0, :2] + STAGGERED.points[-1, :2]) / 2)
    for number in range(count):
        around = 2 * math.pi * number / count
        tilt = 0.45 * math.cos(around), 0.45 * math.sin(around)
        aim = 0.05 * math.cos(2.4 * number), 0.05 * math.sin(2.4 * number)
        where = pose(middle, 0.42 * rng.uniform(1.0, 1.2), rng.uniform(-0.2, 0.2), *tilt, aim)
        truth = project(WIDE, (STAGGERED.points @ where[0].T + where[1])[None])[0]
        yield render(WIDE, staggered_grid(STAGGERED), where, rng, hot=number % 2 == 0), truth


def test_a_staggered_grid_of_circles_is_found_in_every_view():
    views = []
    for picture, truth in staggered_views(8):
        found = find_board(picture, STAGGERED)
        assert found is not None
        assert np.sqrt(((found - truth) ** 2).sum(axis=1).mean()) < 0.3
        assert find_board(picture, dataclasses.replace(STAGGERED, staggered=False)) is None
        views.append(found)
    result = calibrate(STAGGERED.points, views, (320, 240), Freedom(0))
    assert result.camera.fx == pytest.approx(WIDE.fx, rel=0.01)


def test_blank_and_unrelated_pictures_hold_no_board():
    rng = np.random.default_rng(4)
    assert find_board(np.full((120, 160), 29500, np.uint16), CHECKS) is None
    assert find_board((29500 + 30 * rng.standard_normal((120, 160))).astype(np.uint16), CHECKS) is None


def test_skew_is_found_where_it_is_asked_for():
    skewed = dataclasses.replace(LEPTON, skew=2.0)
    rng = np.random.default_rng(2)
    views = exact_views(skewed, CHECKS, tilted_poses(CHECKS, LEPTON, 14, rng))
    with_skew = calibrate(CHECKS.points, views, (160, 120), Freedom(skew=True))
    assert with_skew.camera.skew == pytest.approx(2.0, abs=0.3)
    assert with_skew.camera.fx == pytest.approx(150.0, rel=0.003)
    without = calibrate(CHECKS.points, views, (160, 120), Freedom())
    assert without.camera.skew == 0.0
    assert without.rms > with_skew.rms


@pytest.mark.slow
def test_stated_deviations_are_honest():
    """Over many noisy sets the focal length is off by as much as its own sigma says."""
    poses = tilted_poses(CHECKS, LEPTON, 8, np.random.default_rng(3))
    scores = []
    for seed in range(10):
        found = calibrate(CHECKS.points, exact_views(LEPTON, CHECKS, poses, 0.1, seed), (160, 120), Freedom())
        scores.append((found.camera.fx - LEPTON.fx) / found.sigmas["fx"])
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.7


def test_one_view_of_another_board_shows_in_its_own_error():
    views = exact_views(LEPTON, CHECKS, tilted_poses(CHECKS, LEPTON, 10, np.random.default_rng(5)))
    views[6] = views[6] + np.random.default_rng(6).normal(0, 1.5, views[6].shape)
    found = calibrate(CHECKS.points, views, (160, 120), Freedom())
    assert found.view_rms.argmax() == 6
    assert found.view_rms[6] > 5 * np.median(found.view_rms)
    assert found.camera.fx == pytest.approx(150.0, rel=0.01), "and does not spoil the rest"


def test_two_views_are_too_few():
    views = exact_views(LEPTON, CHECKS, tilted_poses(CHECKS, LEPTON, 2, np.random.default_rng(1)))
    with pytest.raises(BadInput, match="found in 2 pictures, at least 3"):
        calibrate(CHECKS.points, views, (160, 120), Freedom())


@pytest.mark.parametrize("noise", [0.01, 0.2])
def test_views_from_the_front_only_are_refused_however_well_they_fit(noise):
    middle = (0.14, 0.08)
    poses = [pose(middle, 0.5 + 0.05 * n, 0.1 * n, math.radians(1.0), 0.0, (0.05 * (n - 3), 0.0)) for n in range(7)]
    with pytest.raises(BadInput, match=r"do not determine the focal length.*tilted by 20° to 45°"):
        calibrate(CHECKS.points, exact_views(LEPTON, CHECKS, poses, noise), (160, 120), Freedom())


def test_points_that_are_not_the_board_s_are_refused():
    views = exact_views(LEPTON, CHECKS, tilted_poses(CHECKS, LEPTON, 6, np.random.default_rng(1)))
    wrong = Board(5, 8, 0.04)
    with pytest.raises(BadInput, match="px RMS: wrong numbers of columns and rows"):
        calibrate(wrong.points, views, (160, 120), Freedom())


def test_a_box_gives_the_focal_length_and_says_when_it_does_not():
    """The paper's box, 33.5 cm × 22.5 cm, before the paper's camera (eq. 9)."""
    camera = CameraModel.from_fov("e6390", 320, 240, math.radians(45.0))
    rng = np.random.default_rng(7)
    paint, middle = box(0.335, 0.225), (0.1675, 0.1125)
    views = []
    for tilt_x, tilt_y in ((0.6, 0.3), (-0.5, 0.5), (0.2, -0.7)):
        picture = render(camera, paint, pose(middle, 0.75, 0.2, tilt_x, tilt_y), rng)
        views.append(find_box(picture))
    assert all(view is not None for view in views)
    found = calibrate_box(0.335, 0.225, views, (320, 240))
    assert found.camera.fx == pytest.approx(camera.fx, rel=0.02)
    front = find_box(render(camera, paint, pose(middle, 0.75, 0.0, 0.0, 0.0), rng))
    with pytest.raises(BadInput, match="seen from the front"):
        calibrate_box(0.335, 0.225, [front], (320, 240))


@pytest.mark.parametrize("camera", [LEPTON, load_camera("lepton-160"), load_camera("e6390-320"),
                                    dataclasses.replace(LEPTON, skew=1.5, name='say "5"', x=0.1, y=-0.02, z=0.7,
                                                        roll=0.01, pitch=0.9, yaw=-0.3)])  # fmt: skip
def test_a_camera_comes_back_from_its_file_as_it_was(tmp_path, camera):
    file = tmp_path / "camera.toml"
    file.write_text(camera_toml(camera, ["a remark"]))
    back = load_camera(file, mounted=camera.z > 0)
    for entry in dataclasses.fields(CameraModel):
        value = getattr(camera, entry.name)
        exact = isinstance(value, str | tuple)
        assert getattr(back, entry.name) == (value if exact else pytest.approx(value, rel=1e-14)), entry.name
