"""What a planner returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Stage:
    """A part of the planner that ran, such as "tree" or "lattice", and what it took.

    `iterations` are tree extensions, shortcut attempts, simplified paths or expanded cells.
    """

    name: str
    time_ms: float
    iterations: int


@dataclass(frozen=True)
class PlanResult:
    """A path through the goals, and what it took. Lengths in metres, times in milliseconds.

    `status` is "ok" when every goal is visited, else "no_path"; then `path` still visits the goals in `order`,
    and `unreachable` names the others by their number. `reason` says in one line why. `stages` is what ran; their
    iterations add up to `iterations`. `nodes` are those of all trees, and labelled cells of lattices.
    """

    status: str
    algorithm: str
    order: tuple[int, ...]
    path: NDArray[np.float64]  # (N, 2), begins at the start
    goal_indices: tuple[int, ...]  # row of `path` at which each goal of `order` is met
    unreachable: tuple[int, ...]
    iterations: int
    nodes: int
    time_ms: float
    first_solution_ms: float | None
    stages: tuple[Stage, ...] = ()
    reason: str = ""

    @property
    def ok(self) -> bool:
        """True when every goal is visited."""
        return self.status == "ok"

    @property
    def length(self) -> float:
        """Length of the path in metres."""
        return float(np.linalg.norm(np.diff(self.path, axis=0), axis=1).sum())

    def leg(self, visit: int) -> NDArray[np.float64]:
        """The part of the path, (M, 2), that leads to the goal visited as number `visit` (0 is the first)."""
        first = self.goal_indices[visit - 1] if visit > 0 else 0
        return self.path[first : self.goal_indices[visit] + 1]
