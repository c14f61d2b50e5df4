"""Ground laid from real thermal pictures: metres, mines where the boxes are, and clear words when it cannot be."""

from __future__ import annotations

import math
import os
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission.config import Plates
from rover_hil.ground import build
from rover_hil.ground.mosaic import MAX_BOX_M, cuttings
from rover_hil.ground.pictures import TEXTURE_KELVIN, deviations, outside_boxes, read_index

REAL = os.environ.get("ROVER_DATA", "")
needs_data = pytest.mark.skipif(
    not (Path(REAL) / "landmines" / "index.csv").is_file(),
    reason="ROVER_DATA does not name a folder with landmines/ (real thermal pictures)",
)


def mission(**field):
    things = {"rocks": 5, "grass": 4, "surface_mines": 2, "buried_mine_depths": (0.01, 0.02, 0.05)}
    settings = {**things, "placement": "spaced", "world": "", **field}
    return SimpleNamespace(
        time_of_day_s=13 * 3600.0,
        max_duration_s=900.0,
        goals=((2.0, 2.5),),
        area=SimpleNamespace(width=3.0, height=4.0, obstacles=()),
        plates=Plates(),
        launch=SimpleNamespace(pose=Pose2(0.4, 0.4, 0.8), surveyed_radius=0.25),
        field=SimpleNamespace(soil="loam", **settings),
    )


def patch(ground, x, y, radius):
    """Temperatures within `radius` of a point."""
    window = ground.grid.window((x, y), radius)
    return ground.temperature[window][np.hypot(*ground.grid.offsets(window, (x, y))) < radius]


def write_set(folder: Path, rows: list[str], label: str = "0 0.75 0.5 0.1 0.1") -> Path:
    """A made-up picture set: warm square on soil noise, one box, in the layout of the real one."""
    base = folder / "landmines"
    for part in ("images", "labels"):
        (base / part).mkdir(parents=True)
    lines = ["name,zone,session,depth_cm,height_m,centre_temp_c,boxes", *rows]
    (base / "index.csv").write_text("\n".join(lines) + "\n")
    noise = np.random.default_rng(4).normal(110, 12, (640, 640))
    for row in rows:
        name = row.split(",")[0]
        grey = cv2.GaussianBlur(noise, (0, 0), 2) * 3 - 220
        grey[292:348, 452:508] += 90
        cv2.imwrite(str(base / "images" / f"{name}.jpg"), np.clip(grey, 0, 255).astype(np.uint8))
        (base / "labels" / f"{name}.txt").write_text(label + "\n")
    return folder


@pytest.fixture
def made_up(tmp_path):
    rows = [
        f"zone{zone}_A_{i:04d},{zone},A,{depth},5.0,30,1"
        for i, (zone, depth) in enumerate([("4", 0), ("4", 0), ("5", 0), ("1", 1), ("3", 2), ("7", 5)])
    ]
    return write_set(tmp_path, rows)


def test_the_stretch_is_undone_and_the_height_gives_the_scale(made_up):
    entry = read_index(made_up)[0]
    assert entry.width == pytest.approx(2 * 5.0 * math.tan(math.radians(16)))
    assert entry.height == pytest.approx(2 * 5.0 * math.tan(math.radians(13)))
    cx, cy, w, h = entry.boxes[0]
    assert (cx, cy) == pytest.approx((0.75 * entry.width, 0.5 * entry.height))
    assert w / h == pytest.approx(math.tan(math.radians(16)) / math.tan(math.radians(13)))
    kelvin = deviations(made_up, entry, 0.005)
    assert kelvin.shape == (round(entry.height / 0.005), round(entry.width / 0.005))
    soil = outside_boxes(entry, 0.005, kelvin.shape)
    assert float(kelvin[soil].std()) == pytest.approx(TEXTURE_KELVIN, rel=0.1)
    assert kelvin[round(cy / 0.005), round(cx / 0.005)] > 3 * TEXTURE_KELVIN


def test_the_labelled_boxes_become_the_mines(made_up):
    ground = build(mission(), 3, made_up)
    assert [mine.kind for mine in ground.mines] == ["surface"] * 2 + ["buried"] * 3
    assert sorted(mine.depth for mine in ground.mines) == [0.0, 0.0, 0.01, 0.02, 0.05]
    for mine in ground.mines:
        assert mine.contrast_k > 1.0
        centre, around = patch(ground, mine.x, mine.y, 0.03), patch(ground, mine.x, mine.y, 0.25)
        assert np.median(centre) - np.median(around) == pytest.approx(mine.contrast_k, abs=1.0)
    assert ground.truth()["texture"]["kind"] == "real texture, assumed scale"
    assert len(set(ground.truth()["texture"]["mine_pictures"])) == 5


def test_mines_lie_where_they_would_lie_without_pictures(made_up):
    laid, plain = build(mission(), 3, made_up), build(mission(), 3)
    assert [(m.x, m.y) for m in laid.mines] == [(m.x, m.y) for m in plain.mines]
    np.testing.assert_array_equal(laid.obstacles, plain.obstacles)


def test_no_soil_tile_shows_a_labelled_mine(made_up):
    bare = build(mission(rocks=0, grass=0, surface_mines=0, buried_mine_depths=()), 2, made_up)
    blocks = cv2.blur(bare.temperature, (21, 21))  # a mine of the made-up set stays above 3 K in such a mean
    assert float(blocks.max() - np.median(blocks)) < 1.5


def test_pictures_from_too_low_are_not_used(tmp_path):
    folder = write_set(tmp_path, ["zone1_A_0001,1,A,1,2.9,30,1"])
    with pytest.raises(BadInput, match="no picture taken from 3 m or higher"):
        read_index(folder)


def test_a_missing_folder_is_one_clear_line(tmp_path):
    with pytest.raises(BadInput, match=r"landmines.index\.csv: not found") as refused:
        build(mission(), 1, tmp_path)
    assert "\n" not in str(refused.value)


def test_a_missing_picture_is_named(made_up):
    for file in sorted((made_up / "landmines" / "images").glob("zone1*")):
        file.unlink()
    with pytest.raises(BadInput, match="zone1_A_0003"):
        build(mission(), 1, made_up)


def test_a_malformed_index_names_its_line(made_up):
    index = made_up / "landmines" / "index.csv"
    index.write_text(index.read_text().replace("zone4_A_0001,4,A,0,5.0", "zone4_A_0001,4,A,0,high"))
    with pytest.raises(BadInput, match=r"index\.csv line 3"):
        read_index(made_up)


def test_more_mines_than_the_set_holds_are_refused(made_up):
    with pytest.raises(BadInput, match="too few surface mines"):
        build(mission(surface_mines=4), 1, made_up)


@pytest.mark.slow
@needs_data
def test_the_real_set_lays_a_field_of_several_zones_to_the_same_bytes():
    first, second = build(mission(), 11, REAL), build(mission(), 11, REAL)
    assert first.temperature.tobytes() == second.temperature.tobytes()
    texture = first.truth()["texture"]
    assert len({name.split("_")[0] for name in texture["pictures"]}) >= 4
    bare = build(mission(rocks=0, grass=0, surface_mines=0, buried_mine_depths=()), 11, REAL)
    assert 0.4 < float(bare.temperature.std()) < 1.0


@pytest.mark.slow
@needs_data
def test_real_mines_have_plausible_sizes_and_mostly_show():
    entries = read_index(REAL)
    for surface, low, high in ((True, 0.08, 0.35), (False, 0.08, MAX_BOX_M)):
        sizes = [2 * cutting.half for cutting in cuttings(entries, surface)]
        assert len(sizes) > 20
        assert low < np.median(sizes) < high
    contrasts = [mine.contrast_k for seed in (1, 2) for mine in build(mission(), seed, REAL).mines]
    assert np.mean(np.abs(contrasts) > 0.5) >= 0.7
