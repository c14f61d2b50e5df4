"""A field that nobody has tidied up: dense, in clusters, with mines beside rocks and walls, of every size."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput
from rover.mission.config import Mission, load
from rover_hil.ground import build
from rover_hil.ground.placement import Site, try_place
from rover_hil.ground.random_placement import place_at_random

SITE = Site(3.0, 4.0, (0.45, 0.45), (), ())


@pytest.mark.parametrize("seed", range(20))
def test_twenty_rocks_twelve_tufts_and_thirty_mines_fit_and_no_two_are_in_one_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    radii = [*rng.uniform(0.06, 0.18, 20), *rng.uniform(0.08, 0.15, 12)]
    laid = place_at_random(SITE, radii, 30, rng)
    assert [r for _, _, r in laid.obstacles] == radii
    assert len(laid.mines) == 30
    for number, (x, y, r) in enumerate(laid.obstacles):
        assert r <= x <= 3.0 - r
        assert r <= y <= 4.0 - r
        assert math.dist((x, y), SITE.launch) > r + 0.15, "the rover can stand at its launch"
        assert all(math.dist((x, y), other[:2]) >= r + other[2] for other in laid.obstacles[:number])
        assert all(math.dist((x, y), mine) > r for mine in laid.mines)
    assert all(math.dist(mine, SITE.launch) > 0.4 for mine in laid.mines)


def test_spaced_placement_refuses_what_random_lays_and_random_lies_closer() -> None:
    rng = np.random.default_rng(1)
    radii = rng.uniform(0.06, 0.18, 12).tolist()
    assert try_place(SITE, radii, 5, rng, layouts=3) is None
    near = []
    for seed in range(20):
        laid = place_at_random(SITE, radii[:5], 10, np.random.default_rng(seed))
        near += [min(math.dist(m, o[:2]) - o[2] for o in laid.obstacles) for m in laid.mines]
    assert min(near) < 0.1
    assert np.mean(np.array(near) < 0.15) > 0.1


def test_a_field_that_is_full_is_said() -> None:
    with pytest.raises(BadInput, match="do not fit"):
        place_at_random(SITE, [0.18] * 200, 0, np.random.default_rng(1))


def mission(tmp_path: Path, world: str = "", placement: str = "random", **field: object) -> Mission:
    settings = {"rocks": 8, "grass": 4, "surface_mines": 2, "buried_mine_depths_cm": [1.0, 2.0, 5.0], **field}
    file = tmp_path / "mission.toml"
    (tmp_path / "world.toml").write_text(world)
    file.write_text(
        "[area]\nwidth_m = 3.0\nheight_m = 4.0\n[launch]\nx_m = 0.45\ny_m = 0.45\n[field]\n"
        + f'placement = "{placement}"\nworld = "world.toml"\n'
        + "".join(f"{key} = {value}\n" for key, value in settings.items())
    )
    return load(file)


def test_eight_rocks_four_tufts_and_five_mines_are_laid_by_a_mission_that_asks_for_random(tmp_path: Path) -> None:
    one = build(mission(tmp_path), 1)
    assert len(one.obstacles) == 12
    assert len(one.mines) == 5
    again, other = build(mission(tmp_path), 1), build(mission(tmp_path), 2)
    assert again.temperature.tobytes() == one.temperature.tobytes()
    assert other.obstacles.tobytes() != one.obstacles.tobytes()
    with pytest.raises(BadInput, match="spaced, random"):
        mission(tmp_path, placement="dense")


def test_mines_of_every_size_have_the_contrast_of_their_own_radius_and_some_are_bare(tmp_path: Path) -> None:
    text = "[things.mines]\nsmallest_m = 0.03\nlargest_m = 0.10\nexposed = {}\n"
    depths = [2.0] * 12
    hidden = build(mission(tmp_path, text.format(0.0), surface_mines=0, buried_mine_depths_cm=depths), 3)
    radii = np.array([mine.radius for mine in hidden.mines])
    contrast = np.array([mine.contrast_k for mine in hidden.mines])
    assert np.ptp(radii) > 0.03
    assert np.corrcoef(radii, contrast)[0, 1] > 0.9, "by day a larger mine keeps more heat above it"
    (tmp_path / "bare").mkdir()
    bare = build(mission(tmp_path / "bare", text.format(1.0), surface_mines=0, buried_mine_depths_cm=depths), 3)
    assert not np.array_equal(bare.temperature, hidden.temperature)
    assert [replace(mine) for mine in bare.mines] == list(hidden.mines)


def test_litter_makes_small_hot_and_cold_spots_and_no_obstacles(tmp_path: Path) -> None:
    text = "[things.litter]\nholes_per_m2 = 3\nscrap_per_m2 = 3\ntufts_per_m2 = 0\n"
    plain = build(mission(tmp_path), 5)
    (tmp_path / "litter").mkdir()
    littered = build(mission(tmp_path / "litter", text), 5)
    change = littered.temperature - plain.temperature
    assert change.min() < -2.0
    assert len(littered.obstacles) == len(plain.obstacles)
    assert 0.001 < np.mean(np.abs(change) > 0.3) < 0.1
