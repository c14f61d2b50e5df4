"""The second look: a faint, mine-wide spot in uneven soil is found, wider and narrower things count for less."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.detection.second_look import likeness, peaks, sign_at

SIZE = 0.02
MINE = (1.0, 1.4)


def soil(seed: int) -> NDArray[np.float32]:
    """3 x 3 m of soil as uneven as the simulator's: four scales of 0.14 K each, and the camera's noise."""
    rng = np.random.default_rng(seed)
    ground = rng.normal(290.0, 0.02, (150, 150)).astype(np.float32)
    for length in (0.40, 0.15, 0.06, 0.025):
        noise = cv2.GaussianBlur(rng.standard_normal((150, 150), dtype=np.float32), (0, 0), 0.5 * length / SIZE)
        ground += 0.14 * noise / noise.std()
    return ground


def laid(ground: NDArray[np.float32], kelvin: float, half_width: float) -> NDArray[np.float32]:
    """With a spot at MINE that has half its contrast at `half_width` metres from the middle."""
    y, x = (np.mgrid[:150, :150] + 0.5) * SIZE
    distance = np.hypot(x - MINE[0], y - MINE[1])
    return (ground + kelvin * 0.5 ** ((distance / half_width) ** 2)).astype(np.float32)


def at_mine(like: NDArray[np.float32]) -> float:
    row, column = int(MINE[1] / SIZE), int(MINE[0] / SIZE)
    return float(like[row - 3 : row + 4, column - 3 : column + 4].max())


def test_a_kelvin_above_a_mine_stands_out_of_soil_and_bare_soil_hardly_does() -> None:
    with_mine = [at_mine(likeness(laid(soil(seed), 1.0, 0.06), SIZE)) for seed in range(20)]
    bare = sum(len(peaks(likeness(soil(seed), SIZE, 1), SIZE, 3.2)) for seed in range(20))
    assert np.mean(with_mine) > 4.0
    assert sum(z > 2.5 for z in with_mine) >= 18
    assert bare / (20 * 9.0) < 0.5, "spots a square metre"


def test_neither_a_pebble_nor_a_damp_patch_answers_as_a_mine_of_the_same_kelvin_does() -> None:
    mine, pebble, patch = (
        np.mean([at_mine(likeness(laid(soil(seed), 1.0, half), SIZE)) for seed in range(10)])
        for half in (0.06, 0.012, 0.4)
    )
    assert pebble < 0.6 * mine
    assert patch < 0.6 * mine


def test_the_sign_says_whether_warm_or_cold_spots_are_meant() -> None:
    cold = laid(soil(1), -1.0, 0.06)
    assert at_mine(likeness(cold, SIZE, -1)) > 2.5
    assert at_mine(likeness(cold, SIZE, 0)) > 2.5
    assert at_mine(likeness(cold, SIZE, 1)) < 2.0


def test_where_too_little_is_known_nothing_is_said() -> None:
    ground = laid(soil(2), 1.0, 0.06)
    ground[:, int(MINE[0] / SIZE) :] = np.nan
    like = likeness(ground, SIZE)
    assert (like[:, int(MINE[0] / SIZE) - 2 :] == 0.0).all()
    assert (likeness(np.full((20, 20), np.nan, np.float32), SIZE) == 0.0).all()


def test_a_peak_is_told_once_and_where_it_lies() -> None:
    found = peaks(likeness(laid(soil(3), 3.0, 0.06), SIZE), SIZE, 6.0)
    assert len(found) == 1
    assert np.hypot(*(found[0, :2] - MINE)) < 0.03


@pytest.mark.parametrize(("hour", "sign"), [(13.0, 1), (9.0, 1), (7.5, 0), (17.5, 0), (21.0, -1), (3.0, -1)])
def test_by_day_mines_are_warm_at_night_cold_and_about_the_crossings_either(hour: float, sign: int) -> None:
    assert sign_at(hour) == sign
