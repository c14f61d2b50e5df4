"""Plans a square, drives it on the simulated rig in real time, and prints where the rover says that it ended.

python docs/examples/drive_square.py
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from pathlib import Path

from rover.link.clock import WallClock
from rover.link.opening import open_frames
from rover.link.session import STEP_S, Link
from rover.link.telemetry import Odometry
from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import Segment
from rover.motion.trajectory.checked import plan_checked
from rover.planning import CircleField, plan
from rover.vehicle import Vehicle

MISSION = Path(__file__).with_name("square.toml")
LAUNCH, CORNERS = (0.6, 0.6), ((1.1, 0.6), (1.1, 1.1), (0.6, 1.1), (0.6, 0.6))


def square() -> list[Segment]:
    """Constant-jerk segments around a square to the left and back to the launch, its corners rounded."""
    path = plan(CircleField(2.0, 2.0), LAUNCH, CORNERS).path
    return plan_checked(path, DrivingLimits.of(Vehicle(), 0.25), start_heading=0.0).trajectory.segments


def drive(port: str, segments: list[Segment]) -> Odometry:
    """Arms, drives the segments and disarms. Returns the firmware's dead reckoning at the end."""
    clock = WallClock()
    link = Link(open_frames(port, clock=clock), clock)
    link.connect()
    link.arm()
    begins = [index for index, segment in enumerate(segments) if segment.begin] + [len(segments)]
    end = clock.now() + 0.2
    for first, last in itertools.pairwise(begins):  # a run ends wherever the rover comes to rest
        end = link.stream.begin(segments[first:last], end)
    reached = Odometry(0.0, 0.0, 0.0, 0.0)
    while clock.now() < end + 0.5 or (link.state is not None and link.state.moving):  # a busy rig lags behind the clock
        reached = next((event for event in reversed(link.poll()) if isinstance(event, Odometry)), reached)
        clock.advance(clock.now() + STEP_S)
    link.disarm()
    return reached


if __name__ == "__main__":
    serve = [sys.executable, "-m", "rover.cli.main", "hil", "serve", str(MISSION), "--free-run", "--no-camera"]
    with subprocess.Popen(serve, stdout=subprocess.PIPE) as rig:
        assert rig.stdout is not None
        at = drive(json.loads(rig.stdout.readline())["port"], square())
        rig.terminate()
    print(f"back at {at.x:+.3f}, {at.y:+.3f} m from the start, turned by {at.heading:.3f} rad")
