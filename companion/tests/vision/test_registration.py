"""Registration finds what is there, and refuses what is not, on drawn and on real pictures."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.picture import read_picture
from rover.vision.registration.correspondence import Correspondence
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.register import (
    PAPER_EPSILON,
    Registration,
    RegistrationSettings,
    find_features,
    prepare,
    register,
    register_features,
    register_prepared,
    registered_by,
    rmse,
)

from companion.tests.vision.thermal_scene import texture


def scene(seed: int) -> np.ndarray:
    ground = texture(np.random.default_rng(seed))[200:840, 200:1000]
    picture: np.ndarray = np.clip((ground - 299.0) * 127.0, 0, 255).astype(np.uint8)
    return picture


def warped(picture: np.ndarray, homography: np.ndarray, size: tuple[int, int]) -> NDArray[np.uint8]:
    """An 8-bit picture seen through the homography, of that size (width, height)."""
    return cv2.warpPerspective(picture, homography, size).astype(np.uint8, copy=False)


def corner_error(found: Registration, truth: np.ndarray, shape: tuple[int, ...]) -> float:
    height, width = shape[:2]
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    assert found.homography is not None
    apart = apply_homography(found.homography, corners) - apply_homography(truth, corners)
    return float(np.linalg.norm(apart, axis=1).mean())


def test_rmse_is_equation_6() -> None:
    assert rmse(np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([[3.0, 4.0], [1.0, 1.0]])) == pytest.approx(np.sqrt(12.5))


def test_a_turned_scaled_and_tilted_picture_is_found_again() -> None:
    picture = scene(1)
    turn = np.vstack((cv2.getRotationMatrix2D((400, 320), 25.0, 0.9), [0, 0, 1]))
    truth = np.array([[1, 0, 20], [0, 1, -10], [1e-4, 5e-5, 1]]) @ turn
    moved = warped(picture, truth, (800, 640))
    found = register(picture, moved)
    assert found.status == "ok"
    assert corner_error(found, truth, picture.shape) < 1.0
    assert found.rmse_after is not None
    assert found.rmse_before is not None
    assert found.rmse_after < 2.0 < 50.0 < found.rmse_before
    assert found.keypoints[0] >= found.matches >= found.clustered >= found.inliers == len(found.points_a)


@pytest.mark.parametrize(
    "settings",
    [RegistrationSettings(cluster="position", epsilon=PAPER_EPSILON), RegistrationSettings(estimator="ransac")],
    ids=["clustering by position", "plain RANSAC"],
)
def test_the_papers_ways_can_be_chosen(settings: RegistrationSettings) -> None:
    picture = scene(1)
    truth = np.vstack((cv2.getRotationMatrix2D((400, 320), 25.0, 0.9), [0, 0, 1]))
    moved = warped(picture, truth, (800, 640))
    found = register(picture, moved, settings)
    assert corner_error(found, truth, picture.shape) < 1.0


def test_grass_that_moves_between_the_pictures_does_not_hide_the_ground_below() -> None:
    picture = scene(1)
    truth = np.array([[0.8, 0.0, 90.0], [0.0, 0.8, 40.0], [0.0, 0.0, 1.0]])
    x, y = np.meshgrid(np.arange(800, dtype=np.float32), np.arange(640, dtype=np.float32))
    sway = np.random.default_rng(2).normal(0.0, 1.0, (2, 640, 800)).astype(np.float32)
    aside = [cv2.GaussianBlur(s, (0, 0), 8.0) for s in sway]
    aside = [s / s.std() * 6.0 for s in aside]
    moved = warped(cv2.remap(picture, x + aside[0], y + aside[1], cv2.INTER_LINEAR), truth, (800, 640))
    settings = RegistrationSettings()
    a, b = prepare(picture, settings), prepare(moved, settings)
    assert register_features(a.features, b.features, a.sharp.shape, b.sharp.shape, settings).status == "failed"
    found = register_prepared(a, b, settings)
    assert corner_error(found, truth, picture.shape) < 6.0
    assert found.agreement >= settings.coarse_agreement
    assert found.keypoints[0] >= found.matches >= found.clustered >= found.inliers == len(found.points_a)


@pytest.mark.slow
def test_the_same_pictures_give_the_same_homography_to_the_last_bit() -> None:
    a = scene(1)
    b = np.roll(a, 40, axis=1)
    first, second = register(a, b), register(a, b)
    np.testing.assert_array_equal(first.homography, second.homography)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (scene(1), scene(2)),
        (scene(1), np.full((640, 800), 90, np.uint8)),
        (scene(3), np.random.default_rng(0).integers(0, 255, (640, 800)).astype(np.uint8)),
        (scene(4), scene(4)[:, ::-1].copy()),
    ],
    ids=["another scene", "nothing", "noise", "mirrored"],
)
def test_what_does_not_belong_together_is_refused(a: np.ndarray, b: np.ndarray) -> None:
    found = register(a, b)
    assert found.status == "failed"
    assert found.homography is None
    assert found.reason


@pytest.mark.parametrize(("other", "limit"), [(2, 1.0), (3, 2.0)])
def test_graffiti_is_registered_within_pixels(rover_data: Path, other: int, limit: float) -> None:
    first = read_picture(rover_data / "graf/img1.png")
    found = register(first, read_picture(rover_data / f"graf/img{other}.png"))
    assert found.status == "ok"
    assert corner_error(found, np.loadtxt(rover_data / f"graf/H1to{other}p"), first.shape) < limit


def test_graffiti_from_too_far_aside_is_right_or_refused(rover_data: Path) -> None:
    first = read_picture(rover_data / "graf/img1.png")
    found = register(first, read_picture(rover_data / "graf/img4.png"))
    assert found.status == "failed" or corner_error(found, np.loadtxt(rover_data / "graf/H1to4p"), first.shape) < 6.0


@pytest.mark.slow
def test_neighbours_along_the_facade_register_and_strangers_do_not(rover_data: Path) -> None:
    settings = RegistrationSettings()
    files = sorted((rover_data / "dunr/tiff").iterdir())[:6]
    mines = sorted((rover_data / "landmines/images").iterdir())[::150]
    pictures = [read_picture(f) for f in files + mines]
    features = [find_features(p, settings) for p in pictures]

    def pair(a: int, b: int) -> Registration:
        return register_features(features[a], features[b], pictures[a].shape, pictures[b].shape, settings)

    assert [pair(i, i + 1).status for i in range(len(files) - 1)] == ["ok"] * (len(files) - 1)
    strangers = [(a, b) for a in range(len(files)) for b in range(len(files), len(pictures))]
    assert {pair(a, b).status for a, b in strangers} == {"failed"}


def zoomed(factor: float, turn_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All of a scene in 400×320, its middle larger by `factor` and turned, and the homography between them."""
    picture = cv2.GaussianBlur(scene(5), (0, 0), 0.8)
    whole = np.diag([0.5, 0.5, 1.0])
    turn = np.vstack((cv2.getRotationMatrix2D((400, 320), turn_deg, 0.5 * factor), [0, 0, 1]))
    near = np.array([[1.0, 0.0, -200.0], [0.0, 1.0, -160.0], [0.0, 0.0, 1.0]]) @ turn
    noise = np.random.default_rng(6).normal(0.0, 2.0, (2, 320, 400))
    views = [
        np.clip(cv2.warpPerspective(picture, view, (400, 320), flags=cv2.INTER_AREA) + extra, 0, 255).astype(np.uint8)
        for view, extra in zip((whole, near), noise, strict=True)
    ]
    return views[0], views[1], near @ np.linalg.inv(whole)


@pytest.mark.parametrize(("factor", "turn_deg"), [(1.6, 0.0), (2.3, 40.0), (3.0, -15.0)])
@pytest.mark.parametrize("is_closer", [True, False], ids=["closer", "farther"])
def test_a_picture_of_another_scale_is_found_to_a_pixel(factor: float, turn_deg: float, is_closer: bool) -> None:
    a, b, truth = zoomed(factor, turn_deg)
    if not is_closer:
        a, b, truth = b, a, np.linalg.inv(truth)
    assert corner_error(register(a, b), truth, a.shape) < (factor if is_closer else 1.0)  # of the coarser picture


def test_blobs_find_what_corners_do_not_and_nothing_else() -> None:
    a, b, truth = zoomed(4.0, 100.0)
    assert register(a, b, RegistrationSettings(use_blobs=False)).status == "failed"
    assert corner_error(register(a, b), truth, a.shape) < 3.0
    assert register(a, zoomed(4.0, 100.0)[1][:, ::-1].copy()).status == "failed"


def test_what_the_way_back_contradicts_is_refused() -> None:
    """A wallpaper: shifted by one of its periods it looks the same."""
    settings = RegistrationSettings()
    wallpaper = np.tile(scene(6)[:320, :200], (2, 4))
    one = prepare(wallpaper, settings)
    grid = np.stack(np.meshgrid(np.arange(250.0, 550.0, 15.0), np.arange(40.0, 600.0, 20.0)), axis=-1).reshape(-1, 2)

    def matches(shift: float) -> Correspondence:
        moved = grid + np.array([shift, 0.0])
        return Correspondence((len(grid), len(grid)), (640, 800), (640, 800), grid, moved, grid, moved)

    assert registered_by(one, one, matches(200.0), matches(-200.0), settings).status == "ok"
    found = registered_by(one, one, matches(200.0), matches(0.0), settings)
    assert (found.status, found.homography) == ("failed", None)
    assert "way back" in found.reason


def test_where_a_bush_before_the_wall_has_most_of_the_matches_the_wall_is_registered(rover_data: Path) -> None:
    """The last two frames of the facade; the only marker in both hangs on the wall beside the bush."""
    files = sorted((rover_data / "dunr/tiff").iterdir())
    found = register(read_picture(files[24]), read_picture(files[25]))
    assert found.status == "ok"
    assert found.homography is not None
    marker = apply_homography(found.homography, np.array([[256.68, 222.94]]))
    np.testing.assert_allclose(marker, [[213.10, 229.91]], atol=4.0)
