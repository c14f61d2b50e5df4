"""Random paths to segments: are the limits and the clearance kept, and what does it cost beside toppra?

    python -m tools.bench trajectory                          # 1,000 paths, the tables of docs/results/motion.md
    python -m tools.bench trajectory --paths 50 --json

Half of the paths lie in the open, where a corner may be cut by up to 2 to 20 cm; the other half are planned between
circles (multi-goal RRT), where the map says how much. toppra (https://github.com/hungpham2511/toppra) gets the very
path that was made of them, and the limits of speed, acceleration, turn rate, turn acceleration, lateral acceleration,
clearance and sight. It knows no limit of jerk: what this project's limits of jerk cost is inside the ratio. Turns on
the spot cost toppra the fastest turn with limited speed and acceleration. Limits are checked on 40 states a segment,
computed here by exact evaluation of each segment, not by the code that the rover checks itself with.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rover.geometry import wrap_angle
from rover.motion.path import corner
from rover.motion.path.blend import BlendSettings, Stretch
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import State, advance, after
from rover.motion.trajectory.checked import CheckedTrajectory, plan_checked
from rover.motion.trajectory.extrema import ROUNDING_M
from rover.planning.fields import CircleField
from rover.planning.planner import plan
from rover.vehicle import Vehicle

Array = NDArray[np.float64]

SAMPLES = 40
ROBOT_RADIUS = 0.15
# Distance between toppra's grid points, metres; on curves it is a fortieth of the curve.
GRID = 0.02


@dataclass(frozen=True)
class Outcome:
    """One path. Times in seconds but `planning_ms`; `broken`: names of what was not kept."""

    waypoints: int
    planned: bool
    duration: float
    turning: float
    toppra: float
    toppra_turning: float
    turns: int
    curves: int
    segments: int
    planning_ms: float
    closest: float
    broken: tuple[str, ...]


def open_path(rng: np.random.Generator) -> Array:
    """Legs of 0.2 to 1.5 m, corners of any angle."""
    count = int(rng.integers(3, 13))
    headings = np.cumsum(rng.normal(0.0, 1.0, count))
    steps = rng.uniform(0.2, 1.5, count)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def planned_path(rng: np.random.Generator, seed: int) -> tuple[Array, CircleField]:
    """A tour over three goals between 25 circles on 5 m × 5 m."""
    while True:
        centres = rng.uniform(0.2, 4.8, (25, 2))
        circles = np.column_stack([centres, rng.uniform(0.08, 0.3, 25)])
        field = CircleField(5.0, 5.0, circles.tolist())
        free = rng.uniform(0.2, 4.8, (60, 2))
        free = free[field.clearance(free) > ROBOT_RADIUS + 0.02]
        if len(free) < 4:
            continue
        found = plan(field, tuple(free[0]), [tuple(p) for p in free[1:4]], robot_radius=ROBOT_RADIUS, seed=seed)
        if found.ok:
            return found.path, field


def broken_limits(checked: CheckedTrajectory, limits: DrivingLimits) -> list[str]:
    """Which bounds are exceeded in any of SAMPLES states of any segment, or at all in a jerk."""
    found: set[str] = set()
    state = State()
    for segment in checked.trajectory.segments:
        jerk, turn_jerk = segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6
        for t in np.linspace(0.0, segment.duration_us * 1e-6, SAMPLES).tolist():
            at = advance(state, jerk, turn_jerk, t)
            for name, value, bound in (
                ("speed", at.speed, limits.travel.speed),
                ("acceleration", at.acceleration, limits.travel.acceleration),
                ("jerk", jerk, limits.travel.jerk),
                ("turn rate", at.turn_rate, limits.heading.speed),
                ("turn acceleration", at.turn_acceleration, limits.heading.acceleration),
                ("turn jerk", turn_jerk, limits.heading.jerk),
                ("lateral acceleration", at.speed * at.turn_rate, limits.lateral),
            ):
                if not abs(value) <= bound:
                    found.add(name)
        state = after(state, segment)
    if not state.at_rest:
        found.add("rest at the end")
    return sorted(found)


def closest(checked: CheckedTrajectory, field: CircleField) -> float:
    """Least clearance of the footprint, metres, at positions every 5 ms of an integration of its own."""
    x, y, heading = checked.trajectory.x, checked.trajectory.y, checked.trajectory.heading
    state, points = State(heading=heading), [(x, y)]
    for segment in checked.trajectory.segments:
        count = max(1, math.ceil(segment.duration_us / 5_000))
        before = state
        for number in range(1, count + 1):
            t = segment.duration_us * 1e-6 * number / count
            now = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            way, middle = now.travel - before.travel, 0.5 * (now.heading + before.heading)
            x, y = x + way * math.cos(middle), y + way * math.sin(middle)
            points.append((x, y))
            before = now
        state = after(state, segment)
    return float(field.clearance(np.array(points)).min()) - ROBOT_RADIUS


def toppra_times(stretches: list[Stretch], limits: DrivingLimits) -> tuple[float, float]:
    """Seconds that toppra needs for driving, and the fastest turns on the spot between the stretches."""
    driving = sum(_toppra(stretch, limits) for stretch in stretches)
    turning = 0.0
    for before, behind in pairwise(stretches):
        last = before.pieces[-1]
        angle = abs(wrap_angle(behind.pieces[0].heading - last.heading - last.angle))
        speed, acceleration = limits.heading.speed, limits.heading.acceleration
        flat = max(angle - speed * speed / acceleration, 0.0)
        turning += flat / speed + 2.0 * math.sqrt((angle - flat) / acceleration)
    return driving, turning


def _toppra(stretch: Stretch, limits: DrivingLimits) -> float:
    import toppra
    import toppra.algorithm
    import toppra.constraint

    grid, heading, slope, second, most = [0.0], [0.0], [0.0], [0.0], [0.0]
    begin = turned = 0.0
    for piece in stretch.pieces:
        count = 40 if piece.angle else max(2, math.ceil(piece.length / GRID))
        for number in range(1, count + 1):
            phi, first, bend, _ = corner.derivatives(number / count, piece.shape)
            curvature = piece.angle / piece.length * first
            lateral = math.sqrt(limits.lateral / max(abs(curvature), 1e-9))
            grid.append(begin + piece.length * number / count)
            heading.append(turned + piece.angle * phi)
            slope.append(curvature)
            second.append(piece.angle / piece.length**2 * bend)
            most.append(min(limits.travel.speed, lateral, piece.bound))
        begin, turned = grid[-1], heading[-1]
    points = np.array(grid)

    class Path(toppra.interpolator.AbstractGeometricPath):
        dof = 2
        path_interval = np.array([0.0, points[-1]])
        waypoints = None

        def __call__(self, s, order=0):
            line = (s, np.ones_like(s), np.zeros_like(s))[order]
            return np.stack([line, np.interp(s, points, (heading, slope, second)[order])], axis=-1)

    def bounds(s: float) -> Array:
        v, w = float(np.interp(s, points, most)), limits.heading.speed
        return np.array([[-v, v], [-w, w]])

    accelerations = np.array([limits.travel.acceleration, limits.heading.acceleration])
    constraints = [
        toppra.constraint.JointVelocityConstraintVarying(bounds),
        toppra.constraint.JointAccelerationConstraint(np.column_stack([-accelerations, accelerations])),
    ]
    most[0] = most[1]
    instance = toppra.algorithm.TOPPRA(constraints, Path(), gridpoints=points, solver_wrapper="seidel")
    _, speeds, _ = instance.compute_parameterization(0.0, 0.0)
    if speeds is None:
        return math.nan
    return float(np.sum(2.0 * np.diff(points) / (speeds[:-1] + speeds[1:])))


def measure(seed: int, limits: DrivingLimits) -> Outcome:
    """One path, from its seed alone."""
    rng = np.random.default_rng([seed, 7])
    field = None
    if seed % 2:
        path, field = planned_path(rng, seed)
        clearance, settings = ClearanceMap.of(field, ROBOT_RADIUS), BlendSettings(max_cut=0.3)
    else:
        path, clearance = open_path(rng), None
        settings = BlendSettings(max_cut=float(rng.uniform(0.02, 0.2)))
    begun = time.perf_counter()
    checked = plan_checked(path, limits, settings, clearance)
    planning_ms = 1e3 * (time.perf_counter() - begun)
    broken = broken_limits(checked, limits)
    gap = closest(checked, field) if field is not None else math.nan
    if gap < -ROUNDING_M:
        broken.append("clearance")
    if checked.trajectory.failure:
        broken.append("profile")
    driving, turning = toppra_times(checked.stretches, limits)
    segments = checked.trajectory.segments
    spot = sum(s.duration_us for s in _turns(checked)) * 1e-6
    return Outcome(
        len(path),
        field is not None,
        checked.trajectory.duration,
        spot,
        driving + turning,
        turning,
        len(checked.stretches) - 1,
        sum(piece.angle != 0.0 for stretch in checked.stretches for piece in stretch.pieces),
        len(segments),
        planning_ms,
        gap,
        tuple(broken),
    )


def _turns(checked: CheckedTrajectory) -> list:
    """Segments of the turns on the spot: those of runs without jerk of travel from rest."""
    found, run = [], []
    for segment in checked.trajectory.segments:
        run.append(segment)
        if segment.rest:
            if all(each.jerk_travel == 0 for each in run):
                found += run
            run = []
    return found


def hundred_waypoints(limits: DrivingLimits, repetitions: int) -> tuple[float, float, int]:
    """Processor time in ms for 100 waypoints to checked segments: median, p95; and how many segments the last has."""
    times, count = [], 0
    for seed in range(repetitions):
        rng = np.random.default_rng([seed, 8])
        headings = np.cumsum(rng.normal(0.0, 0.7, 99))
        steps = rng.uniform(0.2, 1.0, 99)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
        path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
        begun = time.thread_time()
        checked = plan_checked(path, limits)
        times.append(1e3 * (time.thread_time() - begun))
        count = len(checked.trajectory.segments)
    return float(np.median(times)), float(np.percentile(times, 95)), count


def main(arguments: list[str]) -> int:
    """Prints the tables."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench trajectory", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--paths", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first path")
    parser.add_argument("--lateral", type=float, default=0.25, help="most lateral acceleration, m/s²")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    limits = DrivingLimits.of(Vehicle(), lateral=options.lateral)
    outcomes = [measure(seed, limits) for seed in range(options.first, options.first + options.paths)]
    timing = hundred_waypoints(limits, 101)
    if options.json:
        print(json.dumps(summary(outcomes, timing), indent=2))
    else:
        print(tables(outcomes, timing))
    return 0


def summary(outcomes: list[Outcome], timing: tuple[float, float, int]) -> dict[str, object]:
    """The figures by kind of path."""
    document: dict[str, object] = {}
    for name, group in _groups(outcomes):
        whole = np.array([o.duration / o.toppra for o in group])
        driving = np.array([(o.duration - o.turning) / (o.toppra - o.toppra_turning) for o in group])
        document[name] = {
            "paths": len(group),
            "broken": sum(bool(o.broken) for o in group),
            "least_clearance_mm": 1e3 * min((o.closest for o in group if o.planned), default=math.nan),
            "curves": sum(o.curves for o in group),
            "turns": sum(o.turns for o in group),
            "to_toppra": _spread(whole),
            "to_toppra_driving": _spread(driving),
            "planning_ms": _spread(np.array([o.planning_ms for o in group])),
        }
    document["hundred_waypoints_ms"] = {"median": timing[0], "p95": timing[1], "segments": timing[2]}
    return document


def _groups(outcomes: list[Outcome]) -> list[tuple[str, list[Outcome]]]:
    return [
        (name, group)
        for name, group in (
            ("open", [o for o in outcomes if not o.planned]),
            ("between circles", [o for o in outcomes if o.planned]),
            ("all", outcomes),
        )
        if group
    ]


def _spread(values: Array) -> dict[str, float]:
    return {
        "median": float(np.median(values)),
        "p95": float(np.percentile(values, 95)),
        "most": float(np.max(values)),
    }


def tables(outcomes: list[Outcome], timing: tuple[float, float, int]) -> str:
    """Markdown."""
    lines = [
        "| paths | | limits or clearance not kept | least clearance | corners rounded | turned on the spot "
        "| time / toppra: median, p95, most | driving alone: median, p95, most | planning, ms: median, p95 |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, group in summary(outcomes, timing).items():
        if name == "hundred_waypoints_ms":
            continue
        whole, driving, ms = group["to_toppra"], group["to_toppra_driving"], group["planning_ms"]
        gap = group["least_clearance_mm"]
        lines.append(
            f"| {name} | {group['paths']} | {group['broken']} | {'' if math.isnan(gap) else f'{gap:.3f} mm'} "
            f"| {group['curves']} | {group['turns']} "
            f"| {whole['median']:.3f}, {whole['p95']:.3f}, {whole['most']:.3f} "
            f"| {driving['median']:.3f}, {driving['p95']:.3f}, {driving['most']:.3f} "
            f"| {ms['median']:.2f}, {ms['p95']:.2f} |"
        )
    lines += [
        "",
        f"100 waypoints to {timing[2]} checked segments: {timing[0]:.2f} ms of processor median, {timing[1]:.2f} p95.",
    ]
    return "\n".join(lines)
