"""Figure 3's multi-goal-seeking RRT in plain Python: what the native tree must agree with, node for node."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

Point = tuple[float, float]
_MASK = (1 << 64) - 1


class SplitMix64:
    """The native planner's random numbers."""

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def uniform(self) -> float:
        """Uniform in [0, 1) with 53 bits."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        z = self._state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
        return ((z ^ (z >> 31)) >> 11) * (1.0 / 9007199254740992.0)


@dataclass
class ReferenceTree:
    """Nodes, parents (-1 for the root), the node that reached each goal (-1: none) and the iterations spent."""

    nodes: list[Point]
    parents: list[int]
    reached: list[int]
    iterations: int = 0
    nearest: list[float] = field(default_factory=list)

    def path(self, goal: int) -> list[Point]:
        """Path = {q_0, q_1, …, q_goal} (eq. 15), traced back from the goal."""
        path = []
        at = self.reached[goal]
        while at != -1:
            path.append(self.nodes[at])
            at = self.parents[at]
        return path[::-1]


def segment_clear(
    width: float, height: float, circles: Sequence[Sequence[float]], a: Point, b: Point, radius: float
) -> bool:
    """Exact check of a disc swept from a to b among circles (x, y, radius); bounds are walls."""
    touch = 1e-9
    for x, y in (a, b):
        if not (
            x >= 0.0 + radius - touch
            and y >= 0.0 + radius - touch
            and x <= width - radius + touch
            and y <= height - radius + touch
        ):
            return False
    dx, dy = b[0] - a[0], b[1] - a[1]
    length_squared = dx * dx + dy * dy
    for x, y, obstacle in circles:
        t = 0.0
        if length_squared > 0.0:
            t = min(max(((x - a[0]) * dx + (y - a[1]) * dy) / length_squared, 0.0), 1.0)
        ex, ey = a[0] + t * dx - x, a[1] + t * dy - y
        reach = radius + obstacle - touch
        if ex * ex + ey * ey < reach * reach:
            return False
    return True


def multi_goal_tree(
    width: float,
    height: float,
    circles: Sequence[Sequence[float]],
    start: Point,
    goals: Sequence[Point],
    *,
    radius: float,
    seed: int,
    iterations: int,
    step: float,
    bias: float,
) -> ReferenceTree:
    """One tree towards all goals. `step` is Δt of eq. 13 and the threshold ε within which a goal counts as met."""
    random = SplitMix64(seed)
    tree = ReferenceTree([start], [-1], [-1] * len(goals), 0, [math.inf] * len(goals))

    def squared(a: Point, b: Point) -> float:
        dx, dy = b[0] - a[0], b[1] - a[1]
        return dx * dx + dy * dy

    def clear(a: Point, b: Point) -> bool:
        return segment_clear(width, height, circles, a, b, radius)

    def meet_goals(node: int) -> None:
        for index, goal in enumerate(goals):
            if tree.reached[index] != -1:
                continue
            d = squared(tree.nodes[node], goal)
            tree.nearest[index] = min(tree.nearest[index], d)
            if d <= step * step and clear(tree.nodes[node], goal):
                tree.nodes.append(goal)
                tree.parents.append(node)
                tree.reached[index] = len(tree.nodes) - 1

    meet_goals(0)
    while tree.iterations < iterations:
        unreached = [index for index in range(len(goals)) if tree.reached[index] == -1]
        if not unreached:
            break
        target = min(unreached, key=lambda index: tree.nearest[index])
        tree.iterations += 1
        if random.uniform() < bias:
            sample = goals[target]
        else:
            u, v = random.uniform(), random.uniform()
            sample = (0.0 + radius + u * (width - 0.0 - 2.0 * radius), 0.0 + radius + v * (height - 0.0 - 2.0 * radius))
        nearest = min(range(len(tree.nodes)), key=lambda i: squared(tree.nodes[i], sample))  # (eq. 12)
        origin = tree.nodes[nearest]
        length = math.sqrt(squared(origin, sample))
        if length == 0.0:
            continue
        if length <= step:
            new = sample
        else:  # (eq. 13)
            fraction = step / length
            new = (
                origin[0] + (sample[0] - origin[0]) * fraction,
                origin[1] + (sample[1] - origin[1]) * fraction,
            )
        if clear(origin, new):
            tree.nodes.append(new)  # (eq. 14)
            tree.parents.append(nearest)
            meet_goals(len(tree.nodes) - 1)
    return tree
