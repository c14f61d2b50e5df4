"""The graph of the submaps: what a closed loop does to all of them, and whether its uncertainty is honest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.geometry import Pose2, wrap_angle
from rover.vision.localization.submap_graph import Edge, SubmapGraph, Tie, edge_between

LAUNCH = Pose2(0.5, 0.5, 0.3)
LAUNCH_SIGMA = (0.005, 0.005, math.radians(0.5))
STEP_SIGMA = np.array((0.01, 0.01, 0.008))
COUNT = 8


def noisy(pose: Pose2, covariance: np.ndarray, rng: np.random.Generator) -> Pose2:
    dx, dy, turn = rng.multivariate_normal(np.zeros(3), covariance).tolist()
    return Pose2(pose.x + dx, pose.y + dy, pose.heading + turn)


def ring(rng: np.random.Generator, closed: bool) -> tuple[SubmapGraph, list[Pose2]]:
    """Submaps once around a square of 8 m, as they are measured, and the true ones."""
    sx, sy, turn = (rng.standard_normal(3) * LAUNCH_SIGMA).tolist()
    # The first submap's frame is where the truth has the rover at the launch less where the mark says.
    stood = Pose2(LAUNCH.x + sx, LAUNCH.y + sy, LAUNCH.heading + turn)
    truth = [stood.compose(LAUNCH.inverse())]
    graph = SubmapGraph(LAUNCH, LAUNCH_SIGMA)
    quarter = Pose2(4.0, 0.0, math.pi / 2 * (1.0 if COUNT == 4 else 0.5))
    covariance = np.diag(np.square(STEP_SIGMA))
    for number in range(1, COUNT):
        truth.append(truth[-1].compose(quarter))
        graph.begin(Edge(number - 1, number, noisy(quarter, covariance, rng), covariance, (4.0, 0.0)))
    if closed:
        between = truth[0].relative_to(truth[-1])
        graph.close(Edge(COUNT - 1, 0, noisy(between, covariance, rng), covariance, (4.0, 0.0)))
    return graph, truth


def errors(graph: SubmapGraph, truth: list[Pose2]) -> np.ndarray:
    return np.array(
        [(g.x - t.x, g.y - t.y, wrap_angle(g.heading - t.heading)) for g, t in zip(graph.poses, truth, strict=True)]
    )


def test_a_closed_loop_mends_the_submaps_on_the_way_and_not_the_first() -> None:
    rng = np.random.default_rng(1)
    runs = [[errors(*ring(rng, closed)) for _ in range(40)] for closed in (False, True)]
    rms = np.sqrt(np.mean(np.square(runs), axis=1))[..., :2]
    np.testing.assert_allclose(rms[1, 0], rms[0, 0], rtol=0.6)
    assert (rms[1, -1] < 0.5 * rms[0, -1]).all()


@pytest.mark.parametrize("closed", [False, True])
def test_the_joint_covariance_is_honest(closed: bool) -> None:
    rng = np.random.default_rng(2)
    lengths = []
    for _ in range(60):
        graph, truth = ring(rng, closed)
        off = errors(graph, truth).ravel()
        lengths.append(off @ np.linalg.solve(graph.covariance, off) / off.size)
    assert 0.85 < np.mean(lengths) < 1.15


def test_the_solution_is_a_minimum() -> None:
    graph, _ = ring(np.random.default_rng(3), closed=True)

    def cost(poses: list[Pose2]) -> float:
        graph.poses = poses
        return sum(float(residual @ weight @ residual) for residual, weight, _ in graph._terms())

    solved = list(graph.poses)
    least = cost(solved)
    for number in range(COUNT):
        for dx, dy, turn in 1e-3 * np.vstack((np.eye(3), -np.eye(3))):
            moved = list(solved)
            pose = moved[number]
            moved[number] = Pose2(pose.x + dx, pose.y + dy, pose.heading + turn)
            assert cost(moved) > least


def test_the_edge_of_one_moment_is_what_both_submaps_say_of_the_rover() -> None:
    rng = np.random.default_rng(4)
    p, q = Pose2(2.0, -1.0, 0.7), Pose2(-3.0, 0.5, 2.0)
    p_covariance, q_covariance = (np.diag(np.square(rng.uniform(0.002, 0.02, 3))) for _ in range(2))
    edge = edge_between(0, (p, p_covariance), 1, (q, q_covariance))
    assert edge.pose.compose(q).distance(p) < 1e-12
    drawn = np.array(
        [
            (pose.x - edge.pose.x, pose.y - edge.pose.y, wrap_angle(pose.heading - edge.pose.heading))
            for pose in (
                noisy(p, p_covariance, rng).compose(noisy(q, q_covariance, rng).inverse()) for _ in range(20_000)
            )
        ]
    )
    np.testing.assert_allclose(np.cov(drawn.T), edge.covariance, rtol=0.1, atol=0.05 * edge.covariance.max())


def test_where_the_rover_is_in_another_submap_is_as_vague_as_its_place_there_drawn_by_chance() -> None:
    rng = np.random.default_rng(5)
    inside, own = Pose2(1.0, 2.0, 0.4), np.diag(np.square((0.004, 0.006, 0.01)))
    off = []
    for _ in range(3000):
        graph, truth = ring(rng, closed=False)
        told, covariance = graph.carried(COUNT - 1, noisy(inside, own, rng), own, 2)
        real = truth[COUNT - 1].compose(inside).relative_to(truth[2])
        error = np.array((told.x - real.x, told.y - real.y, wrap_angle(told.heading - real.heading)))
        off.append(error @ np.linalg.solve(covariance, error) / 3.0)
    assert 0.9 < np.mean(off) < 1.1


def test_points_of_known_place_hold_the_submaps_that_see_them() -> None:
    rng = np.random.default_rng(6)
    before, after = [], []
    for _ in range(30):
        graph, truth = ring(rng, closed=False)
        before.append(errors(graph, truth)[-1, :2])
        for seen in ((1.0, 0.5), (-1.0, 2.0)):
            x, y = truth[-1].transform(np.array([seen]))[0].tolist()
            noise = rng.standard_normal(2) * 0.01
            at = (seen[0] + float(noise[0]), seen[1] + float(noise[1]))
            graph.tie(Tie(COUNT - 1, at, (x, y), np.diag((1e-4, 1e-4))))
        after.append(errors(graph, truth)[-1, :2])
    assert np.sqrt(np.mean(np.square(after))) < 0.3 * np.sqrt(np.mean(np.square(before)))


def test_a_second_edge_from_the_same_place_is_known_from_either_side() -> None:
    graph, _ = ring(np.random.default_rng(7), closed=False)
    again = Edge(0, 1, graph.edges[0].pose, graph.edges[0].covariance, (4.0, 0.3))
    assert graph.knows(again)
    assert not graph.knows(Edge(0, 1, again.pose, again.covariance, (1.0, 0.3)))
    back = Edge(1, 0, again.pose.inverse(), again.covariance, (0.1, 0.1))
    assert graph.knows(back)
