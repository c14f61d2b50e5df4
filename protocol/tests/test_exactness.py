"""A thousand random Ruckig profiles through the real firmware: where it was against where Ruckig says."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass, replace

import numpy as np
import pytest
import ruckig
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, Profile, to_position
from rover.motion.segment import Segment
from rover.vehicle import Limits, Vehicle

from protocol.tests import golden

PROFILES = 1_000
SEED = 20_260_801
ROOT = golden.PROTOCOL.parent
# What ReferenceDistance can tell of travel (m) and heading (rad).
TELEMETRY_STEP = np.array([1e-5, 1e-6])


@dataclass(frozen=True)
class Plan:
    """Ruckig's own trajectories of travel and heading, one after the other, and the segments made of them."""

    pieces: list[tuple[float, ruckig.Trajectory, ruckig.Trajectory]]
    segments: list[Segment]

    def at(self, times: np.ndarray) -> np.ndarray:
        """Travel and heading (m, rad) at times since the start, (n, 2)."""
        return np.array([self._at(float(time)) for time in times])

    def _at(self, time: float) -> list[float]:
        begin, *trajectories = next((p for p in reversed(self.pieces) if p[0] <= time), self.pieces[0])
        time = max(time - begin, 0.0)
        return [t.at_time(min(time, t.duration))[0][0] for t in trajectories]


def solve(start: Axis, target: float, limits: Limits) -> tuple[ruckig.Trajectory, Profile]:
    """Ruckig's trajectory of one axis to rest at `target`, and the companion's pieces of it."""
    request = ruckig.InputParameter(1)
    request.current_position, request.current_velocity = [start.position], [start.speed]
    request.current_acceleration, request.target_position = [start.acceleration], [target]
    request.max_velocity, request.max_acceleration = [limits.speed], [limits.acceleration]
    request.max_jerk = [limits.jerk]
    trajectory = ruckig.Trajectory(1)
    assert int(ruckig.Ruckig(1).calculate(request, trajectory)) >= 0
    return trajectory, to_position(start, target, limits)


def random_plan(chance: np.random.Generator) -> Plan:
    """To a random place and heading; two in three change their mind on the way, at speed and under acceleration."""
    vehicle = Vehicle()
    limits = [
        replace(base, speed=base.speed * chance.uniform(0.3, 1), jerk=base.jerk * chance.uniform(0.4, 1))
        for base in (vehicle.travel, vehicle.heading)
    ]
    state = [Axis(), Axis()]
    begin, pieces, segments = 0.0, [], []
    for last in [True] if chance.random() < 1 / 3 else [False, True]:
        targets = [s.position + chance.uniform(-0.5, 0.5) for s in state]
        solved = [solve(s, target, limit) for s, target, limit in zip(state, targets, limits, strict=True)]
        trajectories, profiles = [s[0] for s in solved], [s[1] for s in solved]
        pieces.append((begin, *trajectories))
        duration = max(t.duration for t in trajectories)
        # On a whole microsecond, as the segments are.
        until = None if last else round(duration * chance.uniform(0.1, 0.9) * 1e6) / 1e6
        segments += merge(*profiles, until=until)
        if until is not None:
            begin += until
            states = [t.at_time(min(until, t.duration)) for t in trajectories]
            state = [Axis(*(value[0] for value in values)) for values in states]
    return Plan(pieces, run(segments))


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    chance = np.random.default_rng(SEED)
    return [random_plan(chance) for _ in range(PROFILES)]


@pytest.fixture(scope="module")
def executed(plans: list[Plan]) -> list[np.ndarray]:
    """For each plan the firmware's (time s, travel m, heading rad)."""
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: it builds the firmware's core for this test")
    build = ["cargo", "build", "--release", "--quiet", "-p", "rover-core", "--example", "execute_runs"]
    subprocess.run(build, cwd=ROOT, check=True, timeout=300)
    text = "\n\n".join(
        "\n".join(f"{s.duration_us} {s.jerk_travel} {s.jerk_heading}" for s in plan.segments) for plan in plans
    )
    binary = ROOT / "target/release/examples/execute_runs"
    result = subprocess.run([binary], input=text, capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    samples = np.fromstring(result.stdout, sep=" ").reshape(-1, 4) * [1, 1e-6, *TELEMETRY_STEP]
    return [samples[samples[:, 0] == number, 1:] for number in range(len(plans))]


@pytest.mark.slow
def test_the_firmware_ends_where_ruckig_does_and_is_never_far_from_it_on_the_way(
    plans: list[Plan], executed: list[np.ndarray], record_property
) -> None:
    ends, between = np.zeros(2), np.zeros(2)
    for plan, samples in zip(plans, executed, strict=True):
        error = np.abs(samples[:, 1:] - plan.at(samples[:, 0]))
        assert samples[-1, 0] > plan.pieces[-1][0]
        ends = np.maximum(ends, error[-1])
        between = np.maximum(between, error.max(axis=0))
    print(f"\n{len(plans)} profiles, {sum(len(s) for s in executed)} samples")
    print(f"at the end:  {ends[0] * 1e3:.3f} mm {ends[1] * 1e3:.3f} mrad")
    print(f"on the way:  {between[0] * 1e3:.3f} mm {between[1] * 1e3:.3f} mrad")
    assert (ends <= 1e-4).all(), ends
    assert (between <= 2e-4).all(), between


def test_the_profiles_are_as_various_as_a_rovers(plans: list[Plan]) -> None:
    counts = [len(plan.segments) for plan in plans]
    assert max(counts) > 20
    assert min(counts) < 12
    assert sum(len(plan.pieces) == 2 for plan in plans) > PROFILES / 2
    assert all(s.duration_us >= 1_000 for plan in plans for s in plan.segments)
