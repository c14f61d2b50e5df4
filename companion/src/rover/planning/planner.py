"""One call from a field, a start and goals to a path: a pure function of its arguments and the seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rover.errors import BadInput
from rover.planning.fields import Field
from rover.planning.result import PlanResult, Stage
from rover.vehicle import STANDARD

if TYPE_CHECKING:
    from rover_native import Outcome, Settings

ALGORITHMS = ("best", "rrt", "rrt-star", "goal-seeking", "multi-goal")


def plan(
    field: Field,
    start: tuple[float, float],
    goals: Sequence[tuple[float, float]],
    *,
    algorithm: str = "best",
    robot_radius: float = STANDARD.radius,
    seed: int = 0,
    iterations: int | None = None,
    budget_ms: float | None = None,
    any_order: bool = False,
    start_recovery_m: float = 0.0,
    corner_cost_m: float = 0.0,
    step_m: float | None = None,
    goal_bias: float | None = None,
) -> PlanResult:
    """A path for a disc of `robot_radius` metres from `start` through all reachable `goals`; points in metres.

    "best" searches lattices, tangents among circles, and trees, and takes what is shortest. The others are the paper's:
    "rrt", "rrt-star" and "goal-seeking" plan goal by goal (section 3.5: each goal becomes the next start), "multi-goal"
    grows one tree towards all goals (figure 3). The paper's equations 12 to 15 are cited in the native source.

    Without `iterations` and `budget_ms` planning ends with what the algorithm finds at once, simplified. With them that
    is improved, and more is never worse. `iterations`: so many tree extensions and shortcut attempts more; the same
    seed gives the same path. `budget_ms`: until so much time is over by the clock, which is not repeatable.

    `any_order` lets the planner choose the order (exact up to 12 goals). `start_recovery_m`: how far a start that is
    nearer to an obstacle than the radius may be moved away from it first, with clearance growing all the way.
    `corner_cost_m` is the length that one corner less is worth. `step_m` is Δt of equation 13 and `goal_bias` the share
    of samples that are a goal, 0 to 1; without them a tenth of the map's diagonal, and what suits the algorithm.

    Raises BadInput for values that make no sense. Goals without a path are named in the result.
    """
    if algorithm not in ALGORITHMS:
        raise BadInput(f"unknown algorithm {algorithm!r}: choose one of {', '.join(ALGORITHMS)}")
    start, points = checked_points(field, start, goals)
    settings = native_settings(
        robot_radius, any_order, start_recovery_m, corner_cost_m, budget_ms, iterations, step_m, goal_bias
    )
    goal_array = np.array(points, dtype=np.float64).reshape(-1, 2)
    found = field.native.plan(start, goal_array, algorithm, int(seed) % 2**64, settings)
    return as_result(field, algorithm, start, points, robot_radius, found)


def checked_points(
    field: Field, start: tuple[float, float], goals: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], list[tuple[float, float]]]:
    """Start and goals as floats on the map. Raises BadInput."""
    begin = _point(field, "the start", start)
    points = [_point(field, f"goal {index + 1}", goal) for index, goal in enumerate(goals)]
    if not points:
        raise BadInput("no goal given: name at least one")
    return begin, points


def native_settings(
    robot_radius: float,
    any_order: bool,
    start_recovery_m: float,
    corner_cost_m: float,
    budget_ms: float | None,
    iterations: int | None,
    step_m: float | None,
    goal_bias: float | None,
) -> Settings:
    """The settings as the native planner takes them. Raises BadInput for one that makes no sense."""
    _number("the robot's radius", robot_radius, 0.0)
    _number("the start recovery", start_recovery_m, 0.0)
    _number("the corner cost", corner_cost_m, 0.0)
    check_budget(budget_ms, iterations)
    if step_m is not None and not (math.isfinite(step_m) and step_m > 0.0):
        raise BadInput(f"the step must be a positive number of metres, not {step_m}")
    if goal_bias is not None and not 0.0 <= goal_bias <= 1.0:
        raise BadInput(f"the goal bias must be between 0 and 1, not {goal_bias}")
    return {
        "robot_radius": float(robot_radius),
        "iterations": iterations,
        "budget_ms": budget_ms,
        "any_order": bool(any_order),
        "start_recovery_m": float(start_recovery_m),
        "corner_cost_m": float(corner_cost_m),
        "step_m": step_m,
        "goal_bias": goal_bias,
    }


def check_budget(budget_ms: float | None, iterations: int | None) -> None:
    """Raises BadInput for a limit that makes no sense."""
    if budget_ms is not None:
        _number("the time budget", budget_ms, 0.0)
    if iterations is not None and iterations < 1:
        raise BadInput(f"iterations must be at least 1, not {iterations}")


def as_result(
    field: Field,
    algorithm: str,
    start: tuple[float, float],
    points: list[tuple[float, float]],
    robot_radius: float,
    found: Outcome,
) -> PlanResult:
    """The native planner's answer with its reasons in words."""
    unreachable = tuple(found["unreachable"])
    return PlanResult(
        status="no_path" if unreachable else "ok",
        algorithm=algorithm,
        order=tuple(found["order"]),
        path=found["path"],
        goal_indices=tuple(found["goal_indices"]),
        unreachable=unreachable,
        iterations=found["iterations"],
        nodes=found["nodes"],
        time_ms=found["time_ms"],
        first_solution_ms=found["first_solution_ms"],
        stages=tuple(Stage(*stage) for stage in found["stages"]),
        reason=_reason(field, start, points, unreachable, found["start_blocked"], robot_radius),
    )


def _reason(
    field: Field,
    start: tuple[float, float],
    points: list[tuple[float, float]],
    unreachable: tuple[int, ...],
    start_blocked: bool,
    radius: float,
) -> str:
    if start_blocked:
        return (
            f"the start ({start[0]:g}, {start[1]:g}) is {field.clearance([start])[0]:.3f} m from the nearest obstacle "
            f"or wall; the robot needs {radius:g} m"
        )
    parts = []
    for index in unreachable:
        x, y = points[index]
        clear = field.segment_clear((x, y), (x, y), radius)
        why = "no way leads there" if clear else f"nearer than {radius:g} m to an obstacle or wall"
        parts.append(f"goal {index + 1} ({x:g}, {y:g}): {why}")
    return "; ".join(parts)


def _point(field: Field, name: str, point: tuple[float, float]) -> tuple[float, float]:
    values = tuple(float(value) for value in point)
    if len(values) != 2 or not all(math.isfinite(value) for value in values):
        raise BadInput(f"{name} must be two finite numbers x,y, not {point}")
    left, bottom, right, top = field.bounds
    if not (left <= values[0] <= right and bottom <= values[1] <= top):
        raise BadInput(
            f"{name} ({values[0]:g}, {values[1]:g}) lies outside the map: x is {left:g} to {right:g}, "
            f"y is {bottom:g} to {top:g}"
        )
    return values[0], values[1]


def _number(name: str, value: float, least: float) -> None:
    if not (math.isfinite(value) and value >= least):
        raise BadInput(f"{name} must be a finite number of at least {least:g}, not {value}")
