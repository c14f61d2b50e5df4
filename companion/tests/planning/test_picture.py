"""The picture of a plan: everything that it speaks of is in it, where it belongs."""

from __future__ import annotations

from pathlib import Path

import cv2
import planning_field as paper
import pytest
from rover.errors import BadInput
from rover.planning import GridField, plan
from rover.planning.plot import GOAL, GROUND, PATH, START, TREE, draw, save, tree_edges


def test_map_tree_path_start_and_goals_are_drawn(tmp_path: Path) -> None:
    field = paper.field()
    result = plan(field, paper.START, paper.GOALS, seed=1)
    tree = tree_edges(field, paper.START, paper.GOALS, paper.RADIUS, 1)
    save(draw(field, paper.START, paper.GOALS, result, paper.RADIUS, tree), tmp_path / "plan.png")
    picture = cv2.imread(str(tmp_path / "plan.png"))
    for colour in (GROUND, TREE, PATH, START, GOAL):
        assert (picture == colour).all(axis=2).any()
    x, y = (24 + round(2.0 * 225), 24 + 900 - round(1.5 * 225))  # the centre of the first circle, y upwards
    assert tuple(picture[y, x]) == GROUND


def test_the_trees_edges_touch_nothing_and_begin_at_the_start() -> None:
    field = paper.field()
    tree = tree_edges(field, paper.START, paper.GOALS, paper.RADIUS, 3)
    assert tuple(tree[0][0]) == paper.START
    assert all(field.segment_clear(tuple(a), tuple(b), paper.RADIUS) for a, b in tree)


def test_cells_are_drawn_with_the_first_row_at_the_bottom() -> None:
    field = GridField([[1, 0], [0, 0]], 1.0)
    picture = draw(field, (1.5, 1.5), [(1.5, 0.5)], plan(field, (1.5, 1.5), [(1.5, 0.5)], robot_radius=0.1), 0.1)
    assert tuple(picture[24 + 880, 24 + 20]) == GROUND
    assert tuple(picture[24 + 20, 24 + 20]) != GROUND


def test_a_picture_that_cannot_be_written_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="must end in"):
        save(cv2.imread(""), tmp_path / "plan.tiff")
    with pytest.raises(BadInput, match="No such file"):
        save(
            draw(paper.field(), (1, 1), [], plan(paper.field(), paper.START, paper.GOALS), 0.1),
            tmp_path / "no" / "a.png",
        )
