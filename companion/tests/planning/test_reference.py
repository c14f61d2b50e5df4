"""The native multi-goal tree against the plain Python one: the same nodes in the same order, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from rover.planning import CircleField

from companion.tests.planning import planning_field as paper
from companion.tests.planning.slow_reference import multi_goal_tree, segment_clear


@pytest.mark.parametrize("seed", range(8))
def test_both_trees_are_identical_on_the_papers_field(seed):
    settings = {"radius": paper.RADIUS, "seed": seed, "iterations": 2000, "step": 0.25, "bias": 0.2}
    ours = multi_goal_tree(paper.WIDTH, paper.HEIGHT, paper.OBSTACLES, paper.START, paper.GOALS, **settings)
    nodes, parents, reached, iterations = paper.field().native.multi_goal_tree(
        paper.START, np.array(paper.GOALS), *settings.values()
    )
    assert nodes.tolist() == [list(node) for node in ours.nodes]
    assert parents == ours.parents
    assert reached == ours.reached
    assert iterations == ours.iterations


def test_both_trees_are_identical_when_a_goal_is_out_of_reach_and_the_tree_grows_large():
    ring = [[1.5 + 0.4 * np.cos(a), 1.5 + 0.4 * np.sin(a), 0.1] for a in np.arange(0.0, 6.28, 0.2)]
    goals = [(1.5, 1.5), (2.7, 2.7)]
    ours = multi_goal_tree(3.0, 3.0, ring, (0.4, 0.4), goals, radius=0.1, seed=1, iterations=700, step=0.2, bias=0.1)
    native = CircleField(3.0, 3.0, ring).native
    nodes, parents, reached, iterations = native.multi_goal_tree((0.4, 0.4), np.array(goals), 0.1, 1, 700, 0.2, 0.1)
    assert len(nodes) > 100  # beyond the size where the index takes over from the linear search
    assert nodes.tolist() == [list(node) for node in ours.nodes]
    assert parents == ours.parents
    assert reached == ours.reached
    assert reached[0] == -1
    assert iterations == 700


def test_both_segment_checks_agree_on_random_segments():
    rng = np.random.default_rng(0)
    field = paper.field()
    answers = []
    for a, b in rng.uniform((0.0, 0.0), (3.0, 4.0), (2000, 2, 2)):
        native = field.segment_clear(tuple(a), tuple(b), paper.RADIUS)
        assert native == segment_clear(3.0, 4.0, paper.OBSTACLES, tuple(a), tuple(b), paper.RADIUS)
        answers.append(native)
    assert 0.05 < np.mean(answers) < 0.95
