"""The map shows what is known and what is not, whatever the shape of the area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rover.report.map_plot import FIELD_PX, MARGINS_PX, draw_map, png_bytes, thumbnail
from rover.report.palette import UNMEASURED, UNSEEN, ZONE
from rover.report.result import MapLayers, RunResult

from companion.tests.report.sample_run import make_result


@pytest.fixture(scope="module")
def drawn(result: RunResult) -> np.ndarray:
    return draw_map(result)


def at(picture: np.ndarray, x: float, y: float) -> tuple[int, ...]:
    """Colour at a place of the 3 m × 4 m field."""
    scale = FIELD_PX / 4.0
    return tuple(picture[round(MARGINS_PX[1] + FIELD_PX - y * scale), round(MARGINS_PX[0] + x * scale)].tolist())


def close(a: tuple[int, ...], b: tuple[int, ...], within: int = 40) -> bool:
    return max(abs(p - q) for p, q in zip(a, b, strict=True)) <= within


def test_indications_are_marked_where_they_are(drawn: np.ndarray, result: RunResult) -> None:
    for detection in result.detections:
        assert close(at(drawn, detection.x, detection.y), ZONE), detection.id
        assert close(at(drawn, detection.x - detection.zone_radius, detection.y), ZONE, 60), detection.id


def test_nothing_at_the_border_is_drawn_over_axes_or_legend(result: RunResult) -> None:
    """Zones, plates and the rover itself are cut off where the map ends."""
    corners = [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (0.0, 4.0)]
    detections = tuple(
        replace(result.detections[0], id=10 + n, x=x, y=y, zone_radius=0.5) for n, (x, y) in enumerate(corners)
    )
    left, top, _, _ = MARGINS_PX
    rows, columns = FIELD_PX, round(FIELD_PX * 0.75)
    around = [draw_map(replace(result, detections=found)) for found in (result.detections[:4], detections)]
    for image in around:
        image[top : top + rows, left : left + columns] = 0
    np.testing.assert_array_equal(around[0], around[1])


def test_unseen_ground_looks_unlike_seen_ground(drawn: np.ndarray) -> None:
    assert close(at(drawn, 1.0, 3.97), UNSEEN)
    assert not close(at(drawn, 1.5, 2.3), UNSEEN)


def test_ground_that_the_operator_surveyed_is_not_hatched(drawn: np.ndarray) -> None:
    assert at(drawn, 0.3, 0.3) == UNMEASURED


def test_an_obstacle_is_darker_than_the_same_ground_without_it(result: RunResult, drawn: np.ndarray) -> None:
    given = result.obstacles[3]
    without = draw_map(replace(result, obstacles=()))
    assert sum(at(drawn, given.x, given.y)) < sum(at(without, given.x, given.y))


@pytest.mark.parametrize(("width", "height"), [(20.0, 2.0), (1.0, 12.0), (0.5, 0.5)])
def test_the_legend_has_room_beside_every_shape_of_area(width: float, height: float) -> None:
    shape = (round(height / 0.1), round(width / 0.1))
    layers = MapLayers((0.0, 0.0), 0.1, np.full(shape, 300.0, np.float32), np.ones(shape, bool), np.zeros(shape, bool))
    picture = draw_map(make_result(area_width=width, area_height=height, layers=layers), field_pixels=600)
    assert picture.shape[0] >= 900
    border = np.concatenate([picture[-4:].reshape(-1, 3), picture[:, -4:].reshape(-1, 3)])
    assert (border == border[0]).all()  # nothing runs over the edge


def test_a_mission_that_saw_and_did_nothing_has_a_map_too(result: RunResult) -> None:
    shape = result.layers.seen.shape
    blank = MapLayers(
        (0.0, 0.0), 0.02, np.full(shape, np.nan, np.float32), np.zeros(shape, bool), np.zeros(shape, bool)
    )
    empty = replace(result, layers=blank, path=np.empty((0, 3)), detections=(), goals=(), obstacles=(), final_pose=None)
    assert close(at(draw_map(empty), 1.5, 2.0), UNSEEN)


def test_a_thumbnail_cut_off_by_the_border_is_not_stretched() -> None:
    piece = np.full((10, 30), 300.0, np.float32)
    picture = thumbnail(piece, size=90)
    assert picture.shape == (90, 90, 3)
    assert tuple(picture[5, 45].tolist()) == UNSEEN
    assert tuple(picture[45, 45].tolist()) != UNSEEN


def test_the_same_result_gives_the_same_bytes(drawn: np.ndarray) -> None:
    assert png_bytes(drawn) == png_bytes(draw_map(make_result()))
