"""Maps: exact clearance, conservative grids, and files that are wrong in one clear line."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
import rover_native
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.planning import CircleField, GridField, load_field, plan

from companion.tests.planning import planning_field as paper

FIELD = "width = 3.0\nheight = 4.0\nobstacles = [[2.0, 1.5, 0.20], [1.3, 1.1, 0.15]]\n"


def squares_distance(blocked: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points (cells) to the nearest blocked square, by brute force."""
    rows, columns = np.nonzero(blocked)
    low = np.stack([columns, rows], axis=1).astype(float)
    gap = np.maximum(np.maximum(low[None] - points[:, None], points[:, None] - low[None] - 1.0), 0.0)
    nearest: np.ndarray = np.hypot(gap[..., 0], gap[..., 1]).min(axis=1)
    return nearest


@given(st.integers(0, 2**32 - 1), st.integers(1, 25), st.integers(1, 25), st.floats(0.01, 0.6))
@settings(max_examples=60, deadline=None)
def test_the_clearance_map_is_the_exact_distance_to_the_nearest_blocked_square(seed, height, width, density):
    blocked = np.random.default_rng(seed).random((height, width)) < density
    blocked[0, 0] = True
    centres = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1).reshape(-1, 2)
    expected = squares_distance(blocked, centres).reshape(height, width)
    found = rover_native.clearance_map(np.ascontiguousarray(blocked).view(np.uint8), 0.5)
    np.testing.assert_allclose(found, 0.5 * expected, atol=1e-5)


@given(st.integers(0, 2**32 - 1), st.floats(0.2, 3.0))
@settings(max_examples=60, deadline=None)
def test_the_swept_check_on_a_grid_never_passes_what_a_dense_check_refuses(seed, radius):
    rng = np.random.default_rng(seed)
    blocked = rng.random((20, 30)) < 0.02
    blocked[10, 15] = True
    field = GridField(blocked, 1.0)
    for a, b in rng.uniform((0.0, 0.0), (30.0, 20.0), (20, 2, 2)):
        points = a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a)
        inside = (points >= radius).all() and (points <= np.array([30.0, 20.0]) - radius).all()
        nearest = squares_distance(blocked, points).min()
        answer = field.segment_clear(a, b, radius)
        if answer:
            assert inside
            assert nearest >= radius - 1e-6
        elif inside:
            assert nearest < radius + 0.1  # and it is not more careful than the sampling can tell


def test_walls_count_for_the_robots_radius():
    field = CircleField(2.0, 1.0)
    assert field.segment_clear((0.15, 0.15), (1.85, 0.85), 0.15)
    assert not field.segment_clear((0.14, 0.5), (1.0, 0.5), 0.15)
    assert field.clearance([(0.3, 0.5), (1.0, 0.9)]) == pytest.approx([0.3, 0.1])


def test_a_circle_field_is_read_from_toml(tmp_path):
    path = tmp_path / "field.toml"
    path.write_text(FIELD)
    field = load_field(path)
    assert isinstance(field, CircleField)
    assert field.bounds == (0.0, 0.0, 3.0, 4.0)
    assert field.clearance([(2.0, 1.0)])[0] == pytest.approx(0.3)


def test_a_movingai_map_has_x_as_column_and_y_from_the_top(tmp_path):
    path = tmp_path / "small.map"
    path.write_text("type octile\nheight 2\nwidth 4\nmap\n.GS@\nT.W.\n")
    field = load_field(path)
    assert isinstance(field, GridField)
    assert field.blocked.tolist() == [[False, False, False, True], [True, False, True, False]]
    assert field.segment_clear((0.5, 0.5), (2.5, 0.5), 0.3)
    assert not field.segment_clear((0.5, 0.5), (3.5, 0.5), 0.3)


def test_a_map_server_map_has_its_origin_at_the_lower_left(tmp_path):
    picture = np.full((4, 6), 254, dtype=np.uint8)
    picture[0, 5] = 0  # upper right: occupied
    picture[3, 0] = 205  # lower left: unknown
    cv2.imwrite(str(tmp_path / "map.pgm"), picture)
    path = tmp_path / "map.yaml"
    path.write_text(
        "image: map.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    field = load_field(path)
    assert field.bounds == (-1.0, 2.0, 2.0, 4.0)
    assert field.blocked.sum() == 2
    assert field.blocked[0, 0]
    assert field.blocked[3, 5]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.toml", "width = 3.0\n", "height: missing"),
        ("a.toml", "width = 3.0\nheight = -1\n", "height: -1 lies outside"),
        ("a.toml", "width = nan\nheight = 1\n", "width: nan lies outside"),
        ("a.toml", "width = 3\nheight = 4\nobstacles = [[1, 2]]\n", r"entry 1: must be \[x, y, radius\], not"),
        ("a.toml", "width = 3\nheight = 4\nobstacles = [['a', 2, 3]]\n", "obstacles entry 1: must be a number"),
        ("a.toml", "width = 3\nheight = 4\nobstacles = [[1, 2, -0.1]]\n", r"obstacle 1 must be .* radius >= 0"),
        ("a.toml", "width = 3\nheigth = 4\n", r"heigth: unknown key; did you mean height\?"),
        ("a.toml", "width_m = 3\nheight = 4\n", "width_m: unknown key; wrong unit"),
        ("a.toml", "width = \n", "not valid TOML"),
        ("a.map", "type octile\nheight 2\nwidth 4\n", "no line `map`"),
        ("a.map", "type octile\nheight 2\nmap\n....\n....\n", "needs `width N`"),
        ("a.map", "type octile\nheight 3\nwidth 4\nmap\n....\n....\n", "expected 3 rows of 4"),
        ("a.yaml", "resolution: 0.05\n", "image: missing"),
        ("a.yaml", "image: none.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "none.pgm: No such file"),
        ("a.csv", "1,2\n", "must end in .toml, .yaml or .map"),
    ],
)
def test_files_that_are_wrong_say_so_in_one_line(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        load_field(path)
    assert "\n" not in str(caught.value)
    assert name in str(caught.value) or "none.pgm" in str(caught.value)


def test_a_missing_file_is_bad_input(tmp_path):
    with pytest.raises(BadInput, match="No such file"):
        load_field(tmp_path / "nowhere.map")


def test_real_maps_are_planned_no_longer_than_the_octile_optimum():
    data = os.environ.get("ROVER_DATA")
    if not data:
        pytest.skip("ROVER_DATA is not set: the MovingAI maps are not part of the project")
    path = Path(data) / "maps" / "den312d.map"
    field = load_field(path)
    scenarios = [line.split() for line in (Path(data) / "maps" / "den312d.map.scen").read_text().splitlines()[1:]]
    for words in scenarios[5::120]:
        start, goal = (float(words[4]) + 0.5, float(words[5]) + 0.5), (float(words[6]) + 0.5, float(words[7]) + 0.5)
        result = plan(field, start, [goal], robot_radius=1.0 / 3.0, iterations=1500)
        assert result.ok
        assert result.length <= 1.02 * float(words[8])


def test_the_paper_field_is_the_one_the_tests_speak_of():
    assert len(paper.OBSTACLES) == 10
    assert paper.field().clearance([paper.START])[0] > paper.RADIUS


def test_a_passage_into_which_the_robot_just_fits_is_found_with_every_seed():
    blocked = np.ones((60, 120), dtype=bool)
    blocked[2:58, 2:30] = blocked[2:58, 90:118] = False
    blocked[28:32, 30:90] = False  # 0.2 m wide and 3 m long for a robot of 0.2 m: its middle lies between cells
    for seed in range(5):
        result = plan(GridField(blocked, 0.05), (0.5, 0.5), [(5.5, 2.5)], robot_radius=0.1, seed=seed)
        assert result.ok
    blocked[31, 60] = True
    assert plan(GridField(blocked, 0.05), (0.5, 0.5), [(5.5, 2.5)], robot_radius=0.1).unreachable == (0,)


def test_the_first_tour_is_known_well_before_it_is_made_better():
    rng = np.random.default_rng(1)
    blocked = np.zeros((600, 600), dtype=bool)
    for row, column in rng.integers(0, 590, (1200, 2)):
        blocked[row : row + 10, column : column + 10] = True
    goals = [(x, y) for x in (3.0, 15.0, 27.0) for y in (3.0, 15.0, 27.0)]
    for x, y in [*goals, (9.0, 9.0)]:
        blocked[int(y / 0.05) - 12 : int(y / 0.05) + 12, int(x / 0.05) - 12 : int(x / 0.05) + 12] = False
    shares = []
    for seed in range(3):
        field = GridField(blocked, 0.05)
        result = plan(field, (9.0, 9.0), goals, robot_radius=0.1, any_order=True, seed=seed)
        assert len(result.order) + len(result.unreachable) == len(goals)
        assert result.first_solution_ms is not None
        shares.append(result.first_solution_ms / result.time_ms)
    assert min(shares) < 0.85
