"""A planner with a memory: tree, legs and roadmap outlive the map that they were made on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rover_native

from rover.planning.fields import Field
from rover.planning.planner import as_result, check_budget, checked_points, native_settings
from rover.planning.result import PlanResult
from rover.vehicle import STANDARD


@dataclass(frozen=True)
class Repair:
    """What became of the last plan: nodes of its tree or, where repairing its legs was enough, points of those.

    kept: still in use. pruned: dropped. rewired: nodes among those kept that found another parent, or gaps in legs that
    were bridged.
    """

    kept: int = 0
    pruned: int = 0
    rewired: int = 0


class Planner:
    """The multi-goal planner with a memory: each call of `plan` starts from the one before.

    Legs that the new map cuts are repaired where they are cut. Where that is not enough, branches of the tree that the
    map cuts are pruned, what they carried is rewired, and the tree grows only towards goals that it has lost or that
    are new. The start may move and goals may come and go between calls. The same seed and the same calls give the
    same paths.

    The settings are those of `rover.planning.plan`, metres. Raises BadInput for one that makes no sense.
    """

    def __init__(
        self,
        *,
        robot_radius: float = STANDARD.radius,
        seed: int = 0,
        any_order: bool = False,
        start_recovery_m: float = 0.0,
        corner_cost_m: float = 0.0,
        step_m: float | None = None,
        goal_bias: float | None = None,
    ) -> None:
        self._settings = native_settings(
            robot_radius, any_order, start_recovery_m, corner_cost_m, None, None, step_m, goal_bias
        )
        self.robot_radius = float(robot_radius)
        self.repair = Repair()
        self._native = rover_native.NativePlanner(int(seed) % 2**64)

    def plan(
        self,
        field: Field,
        start: tuple[float, float],
        goals: Sequence[tuple[float, float]],
        *,
        iterations: int | None = None,
        budget_ms: float | None = None,
    ) -> PlanResult:
        """As `rover.planning.plan` with "multi-goal", on the map as it is now. Raises BadInput."""
        start, points = checked_points(field, start, goals)
        check_budget(budget_ms, iterations)
        settings = self._settings.copy()
        settings["budget_ms"], settings["iterations"] = budget_ms, iterations
        goal_array = np.array(points, dtype=np.float64).reshape(-1, 2)
        found = self._native.plan(field.native, start, goal_array, settings)
        self.repair = Repair(found["kept"], found["pruned"], found["rewired"])
        return as_result(field, "multi-goal", start, points, self.robot_radius, found)

    def prepare(self, field: Field) -> tuple[int, int]:
        """Builds a roadmap of `field` for when the map changes; its numbers of nodes and edges.

        Meant for idle time after `plan`: it takes several times as long as a plan, and no plan depends on it. Plans
        that follow go around what is new over the roadmap, and search the map itself only where that has no path.
        """
        return self._native.prepare(field.native, self.robot_radius)
