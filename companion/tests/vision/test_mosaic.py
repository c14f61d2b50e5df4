"""Pictures become one mosaic: placed as a whole, without steps in temperature, and what fits nowhere is left out."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.capture.picture import read_picture
from rover.vision.mosaic.picture_graph import GraphSettings, Placement, Tie, place_pictures, rmse_of, solve
from rover.vision.mosaic.stitch import stitch
from rover.vision.registration.homography import apply_homography

from companion.tests.vision.thermal_scene import texture

SIZE = (320, 240)


def views(count: int, offsets: tuple[float, ...] = ()) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """A textured ground in kelvin × 100, pictures of it, and the homographies (3, 3) from it to each picture."""
    ground = (texture(np.random.default_rng(8))[:700, :1400] * 100).astype(np.float32)
    noise = np.random.default_rng(9)
    pictures, onto = [], []
    for number in range(count):
        turn = cv2.getRotationMatrix2D((160, 120), 4.0 * number, 1.0)
        tilt = np.array([[1, 0, 0], [0, 1, 0], [2e-5 * number, -1e-5 * number, 1]])
        view = tilt @ np.vstack((turn, [0, 0, 1])) @ np.array([[1, 0, -90.0 * number - 60], [0, 1, -200], [0, 0, 1]])
        picture = cv2.warpPerspective(ground, view, SIZE) + noise.normal(0, 2, SIZE[::-1])
        shift = offsets[number] if offsets else 0.0
        pictures.append(np.rint(picture + shift).astype(np.uint16))
        onto.append(view)
    return ground, pictures, onto


def placement_error(placement: Placement, onto: list[np.ndarray]) -> float:
    """Largest distance in reference pixels between where a placement and the truth put the pictures' corners."""
    corners = np.array([[0.0, 0.0], [320.0, 0.0], [320.0, 240.0], [0.0, 240.0]])
    apart = [
        np.linalg.norm(
            apply_homography(found, corners)
            - apply_homography(onto[placement.reference] @ np.linalg.inv(onto[number]), corners),
            axis=1,
        ).max()
        for number, found in placement.homographies.items()
    ]
    return float(max(apart))


@pytest.mark.slow
def test_pictures_are_placed_and_the_mosaic_shows_the_ground_temperatures() -> None:
    ground, pictures, onto = views(4, (0.0, 30.0, -30.0, 0.0))  # 0.3 K up and down: a camera's drift
    placement = place_pictures(pictures, GraphSettings())
    assert sorted(placement.homographies) == [0, 1, 2, 3]
    assert placement_error(placement, onto) < 1.0
    assert placement.rmse_px < 0.6
    mosaic, shift = stitch(pictures, placement)
    assert mosaic.dtype == np.uint16
    to_mosaic = shift @ onto[placement.reference]
    expected = cv2.warpPerspective(ground, to_mosaic, mosaic.shape[::-1])
    inside = cv2.erode((mosaic > 0).astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    left = (mosaic.astype(float) - expected)[inside]
    assert np.std(left - np.median(left)) < 6.0  # hundredths of a kelvin; the drifts alone would make 25


@pytest.mark.slow
def test_a_picture_of_something_else_is_left_out() -> None:
    _, pictures, _ = views(3)
    pictures.insert(1, np.random.default_rng(1).integers(29000, 30000, SIZE[::-1]).astype(np.uint16))
    placement = place_pictures(pictures, GraphSettings())
    assert sorted(placement.homographies) == [0, 2, 3]


def test_a_loop_is_closed_instead_of_adding_up() -> None:
    """Four pictures in a ring, each tie off by a pixel the same way: the error spreads over all of them."""
    points = np.random.default_rng(3).uniform(0, 300, (40, 2))
    ties = [Tie(n, (n + 1) % 4, points, points + np.array([1.0, 0.0])) for n in range(4)]
    chained = {n: np.array([[1.0, 0, -n], [0, 1, 0], [0, 0, 1]]) for n in range(4)}
    solved = solve(chained, 0, ties, GraphSettings(scales_px=(10.0,)))
    assert rmse_of(chained, ties, 10.0) == pytest.approx(2.0, abs=0.01)
    assert rmse_of(solved, ties, 10.0) == pytest.approx(1.0, abs=0.05)


def test_a_thing_before_the_wall_does_not_take_the_pictures_with_it_that_mostly_show_it() -> None:
    """Neighbours agree on a bay window by three ties of four; what spans the graph agrees on the wall alone."""
    rng = np.random.default_rng(12)
    bay = np.array([10.0, 0.0])
    ties = []
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 4)):
        points = rng.uniform(0, 300, (50, 2))
        shift = np.where(np.arange(50)[:, None] < 36, bay, 0.0)
        ties.append(Tie(a, b, points, points + shift + rng.normal(0, 0.2, (50, 2))))
    for a, b in ((0, 2), (1, 3), (2, 4), (0, 3), (1, 4), (0, 4)):
        points = rng.uniform(0, 300, (50, 2))
        ties.append(Tie(a, b, points, points + rng.normal(0, 0.2, (50, 2))))
    # Where the chain of neighbours puts them: each another bay's shift along.
    chained = {n: np.array([[1.0, 0, -10.0 * n], [0, 1, 0], [0, 0, 1]]) for n in range(5)}
    corners = np.array([[0.0, 0.0], [300.0, 0.0], [300.0, 300.0], [0.0, 300.0]])

    def off(settings: GraphSettings) -> float:
        found = solve(chained, 0, ties, settings)
        return max(float(np.abs(apply_homography(h, corners) - corners).max()) for h in found.values())

    assert off(GraphSettings()) < 0.5
    assert off(GraphSettings(scales_px=(1.0,), iterations=25)) > 5.0  # what one scale alone makes of it


@pytest.mark.slow
def test_a_real_facade_hangs_together(rover_data: Path) -> None:
    pictures = [read_picture(file) for file in sorted((rover_data / "dunr/tiff").iterdir())[16:22]]
    placement = place_pictures(pictures, GraphSettings())
    assert len(placement.homographies) == 6
    assert placement.rmse_px < 1.5
    assert stitch(pictures, placement)[0].dtype == np.uint16
