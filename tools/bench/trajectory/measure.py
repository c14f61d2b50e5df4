"""One path measured: is it driven, are limits, tolerance and clearance kept, and what does it cost beside toppra?"""

from __future__ import annotations

import math
import time
import zlib
from dataclasses import dataclass

import numpy as np
from rover.errors import RoverError
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.rounding import BlendSettings
from rover.motion.segment import Segment
from rover.motion.trajectory.checked import MAX_PATH_ERROR_M, CheckedTrajectory, plan_checked
from rover.motion.trajectory.driven import ROUNDING_M

from tools.bench.trajectory.independent import broken, distance, integrate
from tools.bench.trajectory.paths import KINDS, ROBOT_RADIUS_M, Case
from tools.bench.trajectory.toppra_peer import shape_time, toppra_times

# As `rover trajectory` has it.
MAX_WIDEN_M = 0.06


@dataclass(frozen=True)
class Outcome:
    """One path. Times in seconds, `planning_ms` of processor time; `broken`: names of what was not kept.

    `refused`: the reason when it was not driven; `ideal`: what toppra needs along the shape that was sampled, nan when
    there is none; `deviation`: metres from the path; `least_clearance`: metres, nan without a map.
    """

    points: int
    refused: str
    broken: tuple[str, ...] = ()
    length: float = math.nan
    duration: float = math.nan
    turning: float = math.nan
    toppra: float = math.nan
    toppra_turning: float = math.nan
    ideal: float = math.nan
    turns: int = 0
    segments: int = 0
    planning_ms: float = math.nan
    deviation: float = math.nan
    least_clearance: float = math.nan


def measure(kind: str, seed: int, limits: DrivingLimits, peer: bool = True) -> Outcome:
    """One path of a kind, from its seed alone; `peer`: with toppra's times."""
    return outcome(KINDS[kind](np.random.default_rng([seed, zlib.crc32(kind.encode())])), limits, peer)


def outcome(case: Case, limits: DrivingLimits, peer: bool = True) -> Outcome:
    """A path planned, integrated anew and compared."""
    clearance = None if case.field is None else ClearanceMap.of(case.field, ROBOT_RADIUS_M)
    begun = time.thread_time()
    try:
        settings = BlendSettings(max_cut=case.tolerance, widen=min(MAX_WIDEN_M, case.tolerance / 3.0))
        checked = plan_checked(case.path, limits, settings, clearance)
    except RoverError as error:
        return Outcome(len(case.path), str(error))
    planning_ms = 1e3 * (time.thread_time() - begun)
    trajectory = checked.trajectory
    if trajectory.failure:
        return Outcome(len(case.path), trajectory.failure)
    motion = integrate(trajectory.segments, trajectory.x, trajectory.y, trajectory.heading)
    found = broken(motion, limits)
    # Every third of the positions, and every point of the path: so that it is quick, and nothing is left out.
    deviation = float(distance(motion.positions[::3], case.path).max())
    if deviation > case.tolerance + MAX_PATH_ERROR_M or deviation > checked.deviation + MAX_PATH_ERROR_M:
        found.append("tolerance")
    if math.dist(motion.positions[-1], case.path[-1]) > 1e-3:
        found.append("end of the path")
    least = math.nan
    if case.field is not None:
        least = float(case.field.clearance(motion.positions).min()) - ROBOT_RADIUS_M
        if least < -ROUNDING_M:
            found.append("clearance")
    driving, turning = toppra_times(checked.stretches, limits) if peer else (math.nan, math.nan)
    return Outcome(
        len(case.path),
        "",
        tuple(found),
        sum(stretch.length for stretch in checked.stretches),
        trajectory.duration,
        1e-6 * sum(segment.duration_us for segment in turns(checked)),
        driving + turning,
        turning,
        shape_time(case.shape, limits) if peer and case.shape is not None else math.nan,
        len(checked.stretches) - 1,
        len(trajectory.segments),
        planning_ms,
        deviation,
        least,
    )


def turns(checked: CheckedTrajectory) -> list[Segment]:
    """Segments of the turns on the spot: those of runs without jerk of travel from rest."""
    found: list[Segment] = []
    run: list[Segment] = []
    for segment in checked.trajectory.segments:
        run.append(segment)
        if segment.rest:
            if all(each.jerk_travel == 0 for each in run):
                found += run
            run = []
    return found


def planning_seconds(points: int, limits: DrivingLimits, seed: int = 0) -> dict[str, float]:
    """Processor time in seconds for paths of so many points: a zigzag, a walk, a dense line, a dense circle, stairs."""
    rng = np.random.default_rng([seed, points])
    number = np.arange(points)
    headings = np.cumsum(rng.normal(0.0, 0.7, points))
    walk = rng.uniform(0.2, 1.0, points)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    turn = 2.0 * math.pi * number / 1000.0
    paths = {
        "zigzag, 0.4 m": np.column_stack([0.3 * number, 0.25 * (number % 2)]),
        "walk, 0.2 to 1 m": np.cumsum(walk, axis=0),
        "walk, 2 to 10 cm": 0.1 * np.cumsum(walk, axis=0),
        "line, 1 mm": np.column_stack([1e-3 * number, 0.0 * number]),
        "circle, 6 mm": np.column_stack([np.cos(turn), np.sin(turn)]),
        "stairs, 1 cm": 0.01 * np.column_stack([(number + 1) // 2, number // 2]),
    }
    found = {}
    for name, path in paths.items():
        begun = time.thread_time()
        plan_checked(path, limits)
        found[name] = time.thread_time() - begun
    return found
