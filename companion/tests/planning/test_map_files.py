"""Map files as the world has them: cut short, wrong, huge, in every mode. Each is a map or one clear line."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.errors import BadInput
from rover.planning import CircleField, Field, GridField, load_field, plan

YAML = "image: map.pgm\nresolution: 0.5\norigin: [0.0, 0.0, 0.0]\n"
SHADES = np.array([[0, 100, 205, 254]], dtype=np.uint8)


def map_server(folder: Path, extra: str = "", picture: bytes | None = None) -> GridField:
    data = picture if picture is not None else cv2.imencode(".pgm", SHADES)[1].tobytes()
    (folder / "map.pgm").write_bytes(data)
    (folder / "map.yaml").write_text(YAML + extra)
    field = load_field(folder / "map.yaml")
    assert isinstance(field, GridField)
    return field


def complaint(load: Callable[[], Field]) -> str:
    """What is said against a file; nothing when it is a map. Any other error fails the test."""
    try:
        load()
    except BadInput as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("extra", "blocked"),
    [
        ("negate: 0\n", [True, True, True, False]),
        ("negate: 1\n", [False, True, True, True]),
        ("negate: 0\nmode: trinary\nfree_thresh: 0.25\n", [True, True, True, False]),
        ("negate: 0\nmode: scale\n", [True, True, True, False]),
        ("mode: raw\nfree_thresh: 0.5\n", [False, True, True, True]),
    ],
)
def test_shades_are_read_as_the_mode_says_and_unknown_ground_is_blocked(tmp_path, extra, blocked):
    assert map_server(tmp_path, extra).blocked.tolist() == [blocked]


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ("resolution: 1e300\n", "make no map"),
        ("origin: [1e300, 0, 0]\n", "origin must be finite and within"),
    ],
)
def test_settings_without_sense_get_one_line(tmp_path, extra, message):
    with pytest.raises(BadInput, match=message) as caught:
        map_server(tmp_path, extra)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "header",
    [b"", b"P5", b"P5\n4 1\n255\n", b"P5\n-4 1\n255\n", b"P5\n999999999 999999999\n255\n\0", b"P9\n4 1\n255\n\0\0\0\0"],
)
def test_a_broken_picture_is_bad_input_or_a_map(tmp_path, header):
    assert "\n" not in complaint(lambda: map_server(tmp_path, "", header))


def test_any_damage_to_a_file_is_bad_input_or_a_map(tmp_path):
    rng = np.random.default_rng(7)
    whole = {
        "a.map": b"type octile\nheight 2\nwidth 4\nmap\n.GS@\nT.W.\n",
        "a.toml": b"width = 3.0\nheight = 4.0\nobstacles = [[2.0, 1.5, 0.2]]\n",
        "map.yaml": YAML.encode() + b"negate: 0\nfree_thresh: 0.196\n",
    }
    (tmp_path / "map.pgm").write_bytes(cv2.imencode(".pgm", SHADES)[1].tobytes())
    for name, data in whole.items():
        for _ in range(150):
            damaged = bytearray(data)
            for place in rng.integers(0, len(data), 3):
                damaged[place] = rng.integers(256)
            (tmp_path / name).write_bytes(bytes(damaged[: rng.integers(1, len(data) + 1)]))
            assert "\n" not in complaint(lambda name=name: load_field(tmp_path / name))


@pytest.mark.parametrize("size", [1e300, float("nan"), float("inf"), 1e-300])
def test_a_field_of_impossible_size_is_bad_input(size):
    with pytest.raises(BadInput, match="width"):
        CircleField(size, 1.0)
    with pytest.raises(BadInput):
        CircleField(1.0, 1.0, [[size, 0.5, size]] if size > 1.0 or size != size else [[0.5, 0.5, -1.0]])


def test_a_hundred_goals_in_any_order_on_cluttered_ground_are_all_visited():
    rng = np.random.default_rng(11)
    blocked = np.zeros((300, 300), dtype=bool)
    for row, column in rng.integers(0, 292, (120, 2)):
        blocked[row : row + 8, column : column + 8] = True
    field = GridField(blocked, 0.05)
    points = [tuple(p) for p in rng.uniform(0.3, 14.7, (400, 2)) if field.segment_clear(tuple(p), tuple(p), 0.15)][:101]
    result = plan(field, points[0], points[1:], any_order=True)
    visited = set(result.order) | set(result.unreachable)
    assert visited == set(range(100))
    assert len(result.order) > 90


def test_a_walled_in_goal_on_a_large_map_is_named_soon():
    blocked = np.zeros((4000, 4000), dtype=bool)
    blocked[3000:3100, [3000, 3099]] = blocked[[3000, 3099], 3000:3100] = True
    result = plan(GridField(blocked, 1.0), (10.0, 10.0), [(3050.0, 3050.0)], robot_radius=0.3)
    assert result.unreachable == (0,)
    assert result.time_ms < 5000.0


@pytest.mark.parametrize(
    ("extra", "unknown", "blocked", "told"),
    [
        ("", "blocked", [True, True, True, False], None),
        ("", "free", [True, False, False, False], "2 cells look unknown and count as free"),
        ("free_thresh: 0.25\n", "blocked", [True, True, True, False], "1 cells have the grey of unknown"),
        ("free_thresh: 0.25\n", "free", [True, False, False, False], "2 cells look unknown and count as free"),
        ("mode: scale\n", "free", [True, True, True, False], "0 cells look unknown"),
        ("mode: raw\n", "free", [False, True, False, False], "2 cells look unknown"),
    ],
)
def test_unknown_ground_counts_as_asked_for_and_is_counted(tmp_path, extra, unknown, blocked, told):
    map_server(tmp_path, extra)
    lines: list[str] = []
    field = load_field(tmp_path / "map.yaml", unknown=unknown, tell=lines.append)
    assert isinstance(field, GridField)
    assert field.blocked.tolist() == [blocked]
    assert len(lines) == (told is not None)
    assert told is None or re.search(told, lines[0])


@pytest.mark.parametrize("kind", ["octile-corner", "hex", "weighted"])
def test_a_movingai_map_of_another_type_is_refused_by_its_type(tmp_path, kind):
    (tmp_path / "a.map").write_text(f"type {kind}\nheight 2\nwidth 3\nmap\n012\n210\nGGG\nGTG\n")
    assert f"a map of type {kind} can't be read" in complaint(lambda: load_field(tmp_path / "a.map"))


def test_a_map_without_cells_says_so(tmp_path):
    (tmp_path / "none.map").write_text("type octile\nheight 0\nwidth 0\nmap\n")
    assert "width and height must be at least 1" in complaint(lambda: load_field(tmp_path / "none.map"))
