"""The plot of a plan: everything that it speaks of is in it, where it belongs, as SVG and as PNG."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.chart import Area, Line, Page, Text
from rover.errors import BadInput
from rover.planning import CircleField, Field, GridField, plan
from rover.planning.plot import LEFT, MAP_SIDE, OBSTACLE, PATH, TOP, draw, outlines, save, tree_edges

from companion.tests.planning import planning_field as paper


def plotted(field: Field, start: tuple[float, float], goals: list[tuple[float, float]], radius: float) -> Page:
    return draw(field, start, goals, plan(field, start, goals, robot_radius=radius, seed=1), radius)


def area(polygon: np.ndarray) -> float:
    x, y = polygon[:, 0], polygon[:, 1]
    return abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2.0


def test_map_tree_path_start_goals_axes_and_legend_are_drawn(tmp_path: Path) -> None:
    field = paper.field()
    result = plan(field, paper.START, paper.GOALS, seed=1)
    tree = tree_edges(field, paper.START, paper.GOALS, paper.RADIUS, 1)
    page = draw(field, paper.START, paper.GOALS, result, paper.RADIUS, tree)
    texts = {mark.text for mark in page.marks if isinstance(mark, Text)}
    assert {"Plan", "x, m", "y, m", "1", "2", "path", "goal", "obstacle", "tree of figure 3"} <= texts
    assert any(f"{result.length:.2f} m" in text for text in texts)
    save(page, tmp_path / "plan.svg")
    save(page, tmp_path / "plan.png")
    assert (tmp_path / "plan.svg").read_text().startswith("<svg")
    image = cv2.imread(str(tmp_path / "plan.png"))
    assert image is not None
    scale = 2.0 * MAP_SIDE / 4.0  # pixels a metre; the field is 4 m high
    x, y = round(2.0 * LEFT + 2.0 * scale), round(2.0 * TOP + (4.0 - 1.5) * scale)  # the first circle's centre
    assert image[y, x].tolist() == [int(OBSTACLE[i : i + 2], 16) for i in (5, 3, 1)]


def test_the_path_is_drawn_where_it_leads_with_y_upwards() -> None:
    page = plotted(CircleField(4.0, 4.0), (1.0, 1.0), [(3.0, 2.0)], 0.1)
    path = next(mark for mark in page.marks if isinstance(mark, Line) and mark.colour == PATH)
    scale = MAP_SIDE / 4.0
    expected = [[LEFT + 1.0 * scale, TOP + 3.0 * scale], [LEFT + 3.0 * scale, TOP + 2.0 * scale]]
    assert path.points.tolist() == expected


def test_the_trees_edges_touch_nothing_and_begin_at_the_start() -> None:
    field = paper.field()
    tree = tree_edges(field, paper.START, paper.GOALS, paper.RADIUS, 3)
    assert tuple(tree[0][0]) == paper.START
    assert all(field.segment_clear(tuple(a), tuple(b), paper.RADIUS) for a, b in tree)


def test_the_outlines_of_a_grid_cover_its_blocked_cells_and_no_others() -> None:
    blocked = np.random.default_rng(3).random((30, 40)) < 0.3
    found = outlines(GridField(blocked, 0.5, (-2.0, 1.0)))
    assert sum(area(polygon) for polygon in found) == pytest.approx(blocked.sum() * 0.25)
    covered = np.zeros_like(blocked)
    for polygon in found:
        left, bottom = np.round((polygon.min(axis=0) - (-2.0, 1.0)) / 0.5).astype(int)
        right, top = np.round((polygon.max(axis=0) - (-2.0, 1.0)) / 0.5).astype(int)
        covered[bottom:top, left:right] = True
    assert (covered == blocked).all()


def test_a_large_grid_is_drawn_in_few_shapes_that_stay_within_the_map() -> None:
    blocked = np.zeros((2500, 1700), dtype=bool)
    blocked[::2, :3] = blocked[-1] = True
    found = outlines(GridField(blocked, 0.1))
    assert len(found) < 1200
    assert max(polygon.max() for polygon in found) <= 250.0 + 1e-9


def test_circles_that_reach_beyond_the_map_are_cut_at_its_bounds() -> None:
    (outline,) = outlines(CircleField(3.0, 2.0, [[3.0, 2.0, 0.5]]))
    assert outline[:, 0].max() == 3.0
    assert outline[:, 1].max() == 2.0
    page = plotted(CircleField(3.0, 2.0, [[3.0, 2.0, 0.5]]), (0.5, 0.5), [(1.0, 1.0)], 0.1)
    assert any(isinstance(mark, Area) for mark in page.marks)


def test_a_plot_that_cannot_be_written_is_bad_input(tmp_path: Path) -> None:
    page = plotted(paper.field(), paper.START, paper.GOALS, 0.15)
    with pytest.raises(BadInput, match=r"must end in \.svg or \.png"):
        save(page, tmp_path / "plan.tiff")
    with pytest.raises(BadInput, match="No such file"):
        save(page, tmp_path / "no" / "a.png")
