"""Mount, uncertainty on the ground and pair of cameras: found again from known truth, refused where undetermined."""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
import pytest
from rover.errors import BadInput
from rover.vision.calibration.board import Board
from rover.vision.calibration.intrinsics import project
from rover.vision.calibration.mount import MOUNT, angles_of, mount_from_ground, read_points
from rover.vision.calibration.pair import ground_homography, pair_from_board
from rover.vision.calibration.uncertainty import UncertainCamera
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

from companion.tests.vision.calibration_scene import tilted_poses

LEPTON = dataclasses.replace(load_camera("lepton-160"), x=0.05, y=-0.03, roll=0.02, yaw=-0.1,
                             distortion=(-0.2, 0.05, 0.001, -0.001))  # fmt: skip
GROUND = np.array([[x, y] for x in (0.3, 0.5, 0.75, 1.0) for y in (-0.25, 0.0, 0.25)])


def test_a_mount_is_found_again_and_its_deviations_are_honest():
    bare = dataclasses.replace(LEPTON, x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0)
    exact = mount_from_ground(bare, LEPTON.ground_to_pixel(GROUND), GROUND)
    assert [getattr(exact.camera, n) for n in MOUNT] == pytest.approx([getattr(LEPTON, n) for n in MOUNT], abs=1e-6)
    scores = []
    for seed in range(20):
        noise = 0.3 * np.random.default_rng(seed).standard_normal(GROUND.shape)
        found = mount_from_ground(bare, LEPTON.ground_to_pixel(GROUND) + noise, GROUND)
        off = np.array([getattr(found.camera, n) - getattr(LEPTON, n) for n in MOUNT])
        assert np.abs(off[:3]).max() < 0.03
        scores.append(off @ np.linalg.solve(found.covariance, off) / 6)
    assert 0.5 < np.median(scores) < 2.5


def test_angles_of_a_rotation_are_those_that_made_it_even_straight_down():
    for pitch in (0.0, 0.9, math.pi / 2):
        camera = dataclasses.replace(LEPTON, pitch=pitch)
        again = dataclasses.replace(camera, **dict(zip(MOUNT[3:], angles_of(camera.base_from_camera), strict=True)))
        np.testing.assert_allclose(again.base_from_camera, camera.base_from_camera, atol=1e-9)


@pytest.mark.parametrize(
    ("pixels", "ground", "says"),
    [
        (np.zeros((3, 2)), np.zeros((3, 2)), "3 are given, at least 4"),
        (np.random.default_rng(0).uniform(0, 100, (6, 2)), np.column_stack((np.arange(6.0), np.zeros(6))), "one line"),
        (np.random.default_rng(0).uniform(0, 100, (12, 2)), GROUND, "(do not determine|from below)"),
    ],
)
def test_points_that_do_not_determine_a_mount_are_refused(pixels, ground, says):
    with pytest.raises(BadInput, match=says):
        mount_from_ground(LEPTON, pixels, ground)


def test_a_table_of_points_names_its_bad_line(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("u,v,x,y\n1,2,3,4\n5,six,7,8\n")
    with pytest.raises(BadInput, match=r"points\.csv, line 3: numbers in columns u, v, x, y"):
        read_points(file, ("u", "v", "x", "y"))


@pytest.mark.slow
def test_uncertainty_on_the_ground_is_that_of_many_draws():
    """A pixel read to 0.5 px by a mount known to 5 mm and 0.3°, and back."""
    sigmas = np.array([0.005, 0.005, 0.005, 0.005, 0.005, 0.005])
    known = UncertainCamera(LEPTON, MOUNT, np.diag(sigmas**2))
    pixels = np.array([[80.0, 30.0], [20.0, 100.0]])
    ground, covariance = known.pixel_to_ground(pixels, 0.5)
    rng = np.random.default_rng(1)
    draws, back = [], []
    for _ in range(1500):
        moved = dict(zip(MOUNT, [getattr(LEPTON, n) for n in MOUNT] + sigmas * rng.standard_normal(6), strict=True))
        camera = dataclasses.replace(LEPTON, **moved)
        draws.append(camera.pixel_to_ground(pixels + 0.5 * rng.standard_normal((2, 2))))
        back.append(camera.ground_to_pixel(ground + 0.01 * rng.standard_normal((2, 2))))
    for point in range(2):
        np.testing.assert_allclose(np.cov(np.array(draws)[:, point].T), covariance[point], atol=0.1 * covariance.max())
    pixel, spread = known.ground_to_pixel(ground, np.broadcast_to(1e-4 * np.eye(2), (2, 2, 2)))
    np.testing.assert_allclose(pixel, pixels, atol=1e-3)
    for point in range(2):
        np.testing.assert_allclose(np.cov(np.array(back)[:, point].T), spread[point], atol=0.1 * spread.max())
    assert np.isnan(known.pixel_to_ground(np.array([[80.0, -400.0]]), 0.5)[0]).all(), "above the horizon"


VISIBLE = CameraModel("visible", 640, 480, 520.0, 520.0, 318.0, 242.0, 0.0, (0.05, -0.02, 0.0, 0.0))
TURN, SHIFT = cv2.Rodrigues(np.array([0.02, -0.05, 0.01]))[0], np.array([0.04, 0.01, -0.005])


def test_the_pair_is_found_again_from_a_board_whichever_end_each_camera_began_at():
    board = Board(8, 5, 0.04)
    rng = np.random.default_rng(8)
    views = []
    for number, (r, t) in enumerate(tilted_poses(board, LEPTON, 8, rng, fill=0.5)):
        points = board.points @ r.T + t
        mine = project(LEPTON, points[None])[0] + 0.05 * rng.standard_normal((40, 2))
        other = project(VISIBLE, (points @ TURN.T + SHIFT)[None])[0] + 0.1 * rng.standard_normal((40, 2))
        views.append((mine, other[::-1] if number % 2 else other))
    pair = pair_from_board(LEPTON, VISIBLE, board.points, views)
    np.testing.assert_allclose(pair.translation, SHIFT, atol=0.003)
    assert np.linalg.norm(cv2.Rodrigues(pair.rotation @ TURN.T)[0]) < math.radians(0.3)
    assert pair.rms < 0.3
    straight = dataclasses.replace(LEPTON, distortion=())
    other = dataclasses.replace(VISIBLE, distortion=())
    homography = ground_homography(straight, other, dataclasses.replace(pair, rotation=TURN, translation=SHIFT))
    e = straight.extrinsic
    optical = GROUND @ e[:3, :2].T + e[:3, 3]
    expected = project(other, (optical @ TURN.T + SHIFT)[None])[0]
    laid = cv2.perspectiveTransform(straight.ground_to_pixel(GROUND).reshape(-1, 1, 2), homography).reshape(-1, 2)
    np.testing.assert_allclose(laid, expected, atol=1e-6)
