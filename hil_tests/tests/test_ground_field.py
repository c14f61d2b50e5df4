"""A built field keeps every clearance that makes it drivable, and says truthfully what lies where."""

from __future__ import annotations

import itertools
import json
import math
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission.config import Plates
from rover_hil.figure_file import write_figure
from rover_hil.ground import build
from rover_hil.ground.__main__ import main
from rover_hil.ground.field import MARGIN_M, site_of
from rover_hil.ground.placement import Site, is_connected
from rover_hil.ground.plot import figure
from rover_hil.ground.soils import SOILS
from rover_hil.ground.things import at_hour

PAPER_FIELD = (
    *((2.0, 1.5, 0.20), (1.3, 1.1, 0.15), (0.6, 0.7, 0.15), (2.6, 1.9, 0.15), (0.8, 1.8, 0.20)),
    *((1.5, 2.0, 0.15), (2.5, 3.1, 0.20), (1.6, 3.0, 0.18), (0.7, 2.9, 0.20), (0.4, 3.6, 0.10)),
)


def mission(hour=13.0, soil="loam", size=(3.0, 4.0), goals=((2.0, 2.5),), known=(), **field):
    things = {"rocks": 5, "grass": 4, "surface_mines": 2, "buried_mine_depths": (0.01, 0.02, 0.05)}
    settings = {**things, "placement": "spaced", "world": "", **field}
    return SimpleNamespace(
        time_of_day_s=hour * 3600.0,
        max_duration_s=900.0,
        goals=goals,
        area=SimpleNamespace(width=size[0], height=size[1], obstacles=known),
        plates=Plates(),
        launch=SimpleNamespace(pose=Pose2(0.4, 0.4, 0.8), surveyed_radius=0.25),
        field=SimpleNamespace(soil=soil, **settings),
    )


@pytest.fixture(scope="module", params=[1, 2, 3])
def ground(request):
    return build(mission(), request.param)


def cell(ground, x, y):
    return int((y - ground.origin_y) / ground.resolution), int((x - ground.origin_x) / ground.resolution)


def patch(ground, x, y, radius):
    """Temperatures within `radius` of a point."""
    window = ground.grid.window((x, y), radius)
    return ground.temperature[window][np.hypot(*ground.grid.offsets(window, (x, y))) < radius]


def test_the_rasters_cover_the_area_and_its_margin(ground):
    assert ground.temperature.dtype == ground.height.dtype == np.float32
    assert ground.temperature.shape == ground.height.shape
    rows, columns = ground.temperature.shape
    assert ground.origin_x <= -MARGIN_M
    assert ground.origin_y <= -MARGIN_M
    assert ground.origin_x + columns * ground.resolution >= 3.0 + MARGIN_M - 1e-9
    assert ground.origin_y + rows * ground.resolution >= 4.0 + MARGIN_M - 1e-9
    assert np.isfinite(ground.temperature).all()
    assert np.isfinite(ground.height).all()


def test_mines_and_obstacles_keep_their_clearances(ground):
    site = site_of(mission())
    obstacles = [tuple(row[:3]) for row in ground.obstacles]
    mines = [(mine.x, mine.y) for mine in ground.mines]
    assert len(mines) == 5
    assert len(obstacles) == 9
    for i, (x, y) in enumerate(mines):
        assert 0.25 <= x <= 2.75
        assert 0.25 <= y <= 3.75
        assert math.dist((x, y), site.launch) >= 0.60
        assert all(math.dist((x, y), other) >= 0.55 for other in mines[:i])
        assert all(math.dist((x, y), (ox, oy)) - r >= 0.40 for ox, oy, r in obstacles)
    for i, (x, y, r) in enumerate(obstacles):
        assert 0.06 <= r <= 0.18
        assert math.dist((x, y), site.launch) - r >= 0.45
        assert all(math.dist((x, y), goal) > r for goal in site.goals)
        assert all(math.dist((x, y), (ox, oy)) - r - other >= 0.60 for ox, oy, other in obstacles[:i])


def test_the_free_space_stays_in_one_piece(ground):
    obstacles = [tuple(row[:3]) for row in ground.obstacles]
    assert is_connected(site_of(mission()), obstacles, [(mine.x, mine.y) for mine in ground.mines])


def test_a_wall_of_obstacles_is_seen_to_cut_the_field():
    site = Site(3.0, 4.0, (0.4, 0.4), (), ())
    wall = [(x, 2.0, 0.15) for x in np.arange(0.2, 3.0, 0.4)]
    assert is_connected(site, wall[:2], [])
    assert not is_connected(site, wall, [])


def test_mines_show_the_contrast_that_the_truth_states(ground):
    for mine in ground.mines:
        centre = np.median(patch(ground, mine.x, mine.y, 0.03))
        around = np.median(patch(ground, mine.x, mine.y, 0.30))
        assert centre - around == pytest.approx(mine.contrast_k, abs=1.1)
    contrast = {mine.depth: mine.contrast_k for mine in ground.mines}
    assert contrast[0.01] == pytest.approx(3.9, abs=0.2)
    assert contrast[0.01] > contrast[0.02] > contrast[0.05] > 0.5


def test_mines_turn_cold_at_night():
    night = build(mission(hour=23.0), 1)
    assert all(mine.contrast_k < 0 for mine in night.mines)


def test_obstacles_stand_above_the_sonar_or_at_least_show_in_the_picture(ground):
    for (x, y, r, height), kind in zip(ground.obstacles, ground.obstacle_kinds, strict=True):
        lowest = 0.10 if kind == "rock" else 0.08
        assert lowest <= height <= 0.25
        window = ground.grid.window((x, y), r)
        inside = np.hypot(*ground.grid.offsets(window, (x, y))) < r
        assert ground.height[window][inside].max() == pytest.approx(height, abs=0.03)
        soil = np.median(ground.temperature)
        assert abs(np.median(patch(ground, x, y, 0.5 * r)) - soil) > 2.0


def test_surface_mines_stand_proud_and_buried_ones_do_not(ground):
    for mine in ground.mines:
        top = ground.height[cell(ground, mine.x, mine.y)]
        assert top == pytest.approx(0.04 if mine.kind == "surface" else 0.0, abs=0.015)


def test_soil_has_texture_on_every_scale_that_the_camera_can_follow():
    bare = build(mission(rocks=0, grass=0, surface_mines=0, buried_mine_depths=()), 5)
    rms = float(bare.temperature.std())
    assert 0.25 <= rms <= 0.6
    smooth = cv2.GaussianBlur(bare.temperature, (0, 0), 0.02 / bare.resolution)
    assert float((bare.temperature - smooth).std()) > 0.12
    assert float(smooth.std()) > 0.12
    assert 0.0005 < float(bare.height.std()) < 0.005


def test_the_same_seed_gives_the_same_bytes_and_another_seed_another_field():
    first, second, other = (build(mission(), seed) for seed in (7, 7, 8))
    assert first.temperature.tobytes() == second.temperature.tobytes()
    assert first.height.tobytes() == second.height.tobytes()
    assert first.truth() == second.truth()
    assert first.truth()["mines"] != other.truth()["mines"]


def test_the_truth_is_plain_json(ground):
    truth = json.loads(json.dumps(ground.truth()))
    assert truth["soil"] == "loam"
    assert truth["hour"] == 13.0
    assert [mine["kind"] for mine in truth["mines"]] == ["surface"] * 2 + ["buried"] * 3
    assert len(truth["grass"]) == 4
    assert len(truth["obstacles"]) == 9


def test_known_obstacles_come_first_and_are_rocks():
    built = build(mission(known=PAPER_FIELD, rocks=0, grass=0, surface_mines=1, buried_mine_depths=(0.02,)), 1)
    np.testing.assert_array_equal(built.obstacles[:, :3], PAPER_FIELD)
    assert set(built.obstacle_kinds) == {"rock"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"soil": "cheese"}, "no soil is called 'cheese'"),
        ({"rocks": 80}, "do not fit"),
        ({"known": ((2.0, 2.4, 0.3),)}, r"mission\.goals\[0\].*inside area\.obstacles\[0\]"),
        ({"size": (90.0, 90.0)}, "too large to simulate"),
    ],
)
def test_impossible_fields_are_refused_in_one_line(change, message):
    with pytest.raises(BadInput, match=message) as refused:
        build(mission(**change), 1)
    assert "\n" not in str(refused.value)


def test_rocks_are_cooler_than_soil_by_day_and_warmer_at_night_and_leaves_are_cool():
    day, night = (at_hour(SOILS["loam"], hour) for hour in (12.0, 22.0))
    assert day.rock_shaded < day.rock_lit < day.soil
    assert night.rock_lit > night.soil
    assert day.leaf < day.soil - 5.0


def test_the_plot_shows_the_temperatures_in_metres_with_y_up(ground):
    axes = figure(ground, marks=False).axes[0]
    (shown,) = axes.images
    left, right, bottom, top = shown.get_extent()
    rows, columns = ground.temperature.shape
    assert (left, bottom) == (-MARGIN_M, -MARGIN_M)
    assert (right - left, top - bottom) == pytest.approx((columns * ground.resolution, rows * ground.resolution))
    assert shown.origin == "lower"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x, m", "y, m")


def test_every_mine_has_a_label_inside_the_map_that_meets_no_other(ground):
    made = figure(ground)
    FigureCanvasAgg(made).draw()
    axes = made.axes[0]
    labels = {text.get_text().split(":")[0]: text for text in axes.texts}
    assert set(labels) == {str(mine.id) for mine in ground.mines}
    boxes = [text.get_window_extent() for text in labels.values()]
    map_box = axes.get_window_extent()
    assert all(map_box.contains(*corner) for box in boxes for corner in box.corners())
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_plot_has_the_format_of_its_ending_and_the_same_bytes_again(tmp_path, ending):
    ground = build(mission(), 1)
    files = [tmp_path / f"{number}.{ending}" for number in (1, 2)]
    for file in files:
        write_figure(figure(ground), file)
    first, second = (file.read_bytes() for file in files)
    assert first == second
    assert first.startswith(b"\x89PNG" if ending == "png" else b"<?xml")


def test_a_plot_of_another_ending_is_one_clear_line(tmp_path):
    with pytest.raises(BadInput, match=r"plot\.pdf: a plot is written as PNG or SVG"):
        write_figure(figure(build(mission(), 1)), tmp_path / "plot.pdf")


def test_the_command_draws_the_shipped_mission(tmp_path, capsys):
    out = tmp_path / "field.png"
    assert main(["--mission", "demo", "--seed", "4", "--out", str(out)]) == 0
    assert cv2.imread(str(out)) is not None
    assert len(json.loads(capsys.readouterr().out)["mines"]) > 0


def test_the_command_says_what_is_missing(capsys):
    assert main(["--seed", "4"]) == 2
    assert capsys.readouterr().err.startswith("error: give --mission FILE and --out PLOT")
