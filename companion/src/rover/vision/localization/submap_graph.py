"""Where the submaps lie in map: a graph of what the rover has seen of one from another, solved as a whole.

A submap is rigid; what bends is how submaps lie to each other. Each time the rover goes over from one into another it
knows its pose in both, which is one edge. The first submap holds on to the launch, a point of known place in map (a
marker plate) holds on to that. Least squares over all of it by Gauss and Newton, dense: a hundred submaps are 300
unknowns. (Hierarchical SLAM: Estrada, Neira and Tardós, IEEE Transactions on Robotics 21, 2005, section III.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle
from rover.vision.localization.pose_filter import difference, relative_pose

Array = NDArray[np.float64]

# Two edges between the same submaps nearer to each other than this, metres, say the same.
EDGE_SPACING_M = 1.0
# Share of the variance that a sight of a known point must have of the former one to take its place.
BETTER_TIE = 0.7
MAX_ITERATIONS = 20
# Metres and radians: a smaller step ends the iteration.
SMALL_STEP = 1e-7


@dataclass(frozen=True, eq=False)
class Edge:
    """Submap `other` lies at `pose` in the frame of submap `first`; covariance (3, 3) in the axes of `first`.

    place: where the rover was when it saw that, x and y in the frame of `first`.
    """

    first: int
    other: int
    pose: Pose2
    covariance: Array
    place: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Tie:
    """A point of the area, known to lie at `known`, was seen at `seen` in a submap; covariance (2, 2) in its axes."""

    submap: int
    seen: tuple[float, float]
    known: tuple[float, float]
    covariance: Array


def edge_between(first: int, in_first: tuple[Pose2, Array], other: int, in_other: tuple[Pose2, Array]) -> Edge:
    """The edge from one moment: the rover's pose and covariance (3, 3) in either submap, independent of each other."""
    (p, p_covariance), (q, q_covariance) = in_first, in_other
    pose = p.compose(q.inverse())
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    # Of p - R q with R the difference of the headings; the derivative of R q by its angle is R q turned by 90°.
    x, y = c * q.x - s * q.y, s * q.x + c * q.y
    of_p = np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])
    of_q = np.array([[-c, s, -y], [-s, -c, x], [0.0, 0.0, -1.0]])
    covariance = of_p @ p_covariance @ of_p.T + of_q @ q_covariance @ of_q.T
    return Edge(first, other, pose, covariance, (p.x, p.y))


class SubmapGraph:
    """Poses of submaps in map with their joint covariance."""

    def __init__(self, launch: Pose2, sigma: tuple[float, float, float]) -> None:
        """launch: of the rover in map, by the operator's mark, and in the first submap; sigma: of x, y (m), heading."""
        self.poses = [Pose2(0.0, 0.0, 0.0)]
        self.edges: list[Edge] = []
        self.ties: list[Tie] = []
        self.launch, self.sigma = launch, sigma
        self.covariance: Array = np.zeros((3, 3))
        self.solve()

    def begin(self, edge: Edge) -> None:
        """Adds the submap `edge.other` where the edge puts it."""
        self.poses.append(self.poses[edge.first].compose(edge.pose))
        self.edges.append(edge)
        self.covariance = _inverse(self._normal_equations()[0])

    def knows(self, edge: Edge) -> bool:
        """True when an edge between the same submaps from about the same place is there."""
        x, y = edge.place
        if edge.first == edge.other:
            return True
        for known in self.edges:
            if (known.first, known.other) == (edge.first, edge.other):
                at = known.place
            elif (known.other, known.first) == (edge.first, edge.other):
                here = known.pose.inverse().transform(np.array([known.place]))[0].tolist()
                at = (here[0], here[1])
            else:
                continue
            if math.hypot(x - at[0], y - at[1]) < EDGE_SPACING_M:
                return True
        return False

    def close(self, edge: Edge) -> None:
        """Takes an edge between submaps that are there, and moves all of them to where they fit best."""
        self.edges.append(edge)
        self.solve()

    def tie(self, tie: Tie) -> bool:
        """Takes a point of known place, and moves all submaps to where they fit best.

        False, and nothing moves, where the same point has been seen in that submap about as well before: frames of one
        place repeat each other's errors.
        """
        same = [n for n, one in enumerate(self.ties) if (one.submap, one.known) == (tie.submap, tie.known)]
        if same:
            if float(tie.covariance.trace()) > BETTER_TIE * float(self.ties[same[0]].covariance.trace()):
                return False
            self.ties[same[0]] = tie
        else:
            self.ties.append(tie)
        self.solve()
        return True

    def solve(self) -> None:
        """Moves the submaps to the least squares of all edges, ties and the launch."""
        for _ in range(MAX_ITERATIONS):
            information, gradient = self._normal_equations()
            step = np.linalg.solve(information, gradient).reshape(-1, 3)
            self.poses = [
                Pose2(pose.x + dx, pose.y + dy, wrap_angle(pose.heading + turn))
                for pose, (dx, dy, turn) in zip(self.poses, step.tolist(), strict=True)
            ]
            if float(np.abs(step).max()) < SMALL_STEP:
                break
        self.covariance = _inverse(information)

    def lifted(self, submap: int, pose: Pose2, covariance: Array) -> tuple[Pose2, Array]:
        """A pose with covariance (3, 3) in a submap's frame, in map."""
        base = self.poses[submap]
        placed = base.compose(pose)
        of_base, of_pose = _composition(base, placed)
        block = self._block(submap, submap)
        lifted: Array = of_base @ block @ of_base.T + of_pose @ covariance @ of_pose.T
        return placed, lifted

    def carried(self, submap: int, pose: Pose2, covariance: Array, other: int) -> tuple[Pose2, Array]:
        """A pose with covariance (3, 3) in a submap's frame, in the frame of another."""
        if submap == other:
            return pose, covariance
        between, of_first, of_other = relative_pose(self.poses[submap], self.poses[other])
        cross = of_first @ self._block(submap, other) @ of_other.T
        apart = (
            of_first @ self._block(submap, submap) @ of_first.T
            + cross
            + cross.T
            + of_other @ self._block(other, other) @ of_other.T
        )
        placed = between.compose(pose)
        of_between, of_pose = _composition(between, placed)
        carried: Array = of_between @ apart @ of_between.T + of_pose @ covariance @ of_pose.T
        return placed, carried

    def _block(self, first: int, other: int) -> Array:
        block: Array = self.covariance[3 * first : 3 * first + 3, 3 * other : 3 * other + 3]
        return block

    def _normal_equations(self) -> tuple[Array, Array]:
        """Information (3S, 3S) and gradient (3S,) at the present poses."""
        size = 3 * len(self.poses)
        information, gradient = np.zeros((size, size)), np.zeros(size)
        for residual, weight, parts in self._terms():
            for at, jacobian in parts:
                weighted = jacobian.T @ weight
                gradient[at : at + 3] += weighted @ residual
                for to, other in parts:
                    information[at : at + 3, to : to + 3] += weighted @ other
        return information, gradient

    def _terms(self) -> Iterator[tuple[Array, Array, list[tuple[int, Array]]]]:
        """Residuals, their information, and where and how the poses move what is expected."""
        placed = self.poses[0].compose(self.launch)
        of_base, _ = _composition(self.poses[0], placed)
        yield difference(self.launch, placed), np.diag(1.0 / np.square(self.sigma)), [(0, of_base)]
        for edge in self.edges:
            expected, of_other, of_first = relative_pose(self.poses[edge.other], self.poses[edge.first])
            weight = _inverse(edge.covariance)
            yield difference(edge.pose, expected), weight, [(3 * edge.other, of_other), (3 * edge.first, of_first)]
        for tie in self.ties:
            base = self.poses[tie.submap]
            point = base.compose(Pose2(*tie.seen, 0.0))
            of_base, _ = _composition(base, point)
            c, s = math.cos(base.heading), math.sin(base.heading)
            turn = np.array([[c, -s], [s, c]])
            residual = np.array([tie.known[0] - point.x, tie.known[1] - point.y])
            weight = _inverse(turn @ tie.covariance @ turn.T)
            yield residual, weight, [(3 * tie.submap, of_base[:2])]


def _inverse(matrix: Array) -> Array:
    """Of a symmetric, positive matrix."""
    inverse = np.linalg.inv(matrix)
    symmetric: Array = 0.5 * (inverse + inverse.T)
    return symmetric


def _composition(base: Pose2, placed: Pose2) -> tuple[Array, Array]:
    """Jacobians (3, 3) of `placed`, which is `base` composed with a pose, by either."""
    c, s = math.cos(base.heading), math.sin(base.heading)
    of_base = np.array([[1.0, 0.0, base.y - placed.y], [0.0, 1.0, placed.x - base.x], [0.0, 0.0, 1.0]])
    return of_base, np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
