"""A rover on a plane: wheels that slip, an estimate that is noisy, a link that starts runs a little later."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from rover.geometry import Pose2, wrap_angle
from rover.motion import CommittedMotion, PathFollower, Segment
from rover.motion.path.clearance import ClearanceMap
from rover.vehicle import Vehicle

CYCLE = 0.02
LATENCY = 0.1
ORIGIN = Pose2(0.0, 0.0, 0.0)


@dataclass
class Log:
    times: list[float] = field(default_factory=list)
    poses: list[Pose2] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    segments: list[Segment] = field(default_factory=list)
    most_ahead: float = 0.0
    finished: bool = False
    restarts: int = 0

    def off_path(self, path: list[tuple[float, float]]) -> float:
        """Largest distance of the true pose from the polyline, metres."""
        points = np.array([(pose.x, pose.y) for pose in self.poses])
        best = np.full(len(points), np.inf)
        for a, b in zip(np.array(path[:-1]), np.array(path[1:]), strict=True):
            along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            best = np.minimum(best, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
        return float(best.max())


def drive(
    path: list[tuple[float, float]],
    final_heading: float | None = None,
    *,
    start: Pose2 = ORIGIN,
    wheels: tuple[float, float] = (1.0, 1.0),
    noise: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
    stop_at: float | None = None,
    push_at: float | None = None,
    twist_at: float | None = None,
    follower: PathFollower | None = None,
    limit: float = 120.0,
    clearance: ClearanceMap | None = None,
) -> tuple[PathFollower, CommittedMotion, Log]:
    """Drives the path; `wheels` is ground per commanded metre left and right, `noise` metres and radians (1 sigma)."""
    rng = np.random.default_rng(seed)
    vehicle = Vehicle()
    follower = follower or PathFollower(vehicle)
    committed = CommittedMotion()
    follower.follow(path, final_heading, clearance)
    log = Log()
    true = start
    error = np.zeros(3)
    for cycle in range(round(limit / CYCLE)):
        now = cycle * CYCLE
        error = 0.8 * error + 0.6 * rng.normal(size=3) * (noise[0], noise[0], noise[1])
        estimate = Pose2(true.x + error[0], true.y + error[1], wrap_angle(true.heading + error[2]))
        if stop_at is not None and abs(now - stop_at) < CYCLE / 2:
            follower.request_stop()
        if push_at is not None and abs(now - push_at) < CYCLE / 2:
            true = Pose2(true.x, true.y + 0.12, true.heading)
        if twist_at is not None and abs(now - twist_at) < CYCLE / 2:
            true = Pose2(true.x, true.y, true.heading + 0.8)
        segments = follower.next_segments(now, estimate, committed)
        if segments:
            committed.append(segments, now + LATENCY if segments[0].begin else None)
            log.segments += segments
            log.most_ahead = max(log.most_ahead, committed.end_time - now)
        if follower.done and now > committed.end_time:
            log.finished = True
            break
        a, b = committed.state_at(now), committed.state_at(now + CYCLE)
        half = vehicle.track_width / 2.0
        left = (b.travel - a.travel - half * (b.heading - a.heading)) * wheels[0]
        right = (b.travel - a.travel + half * (b.heading - a.heading)) * wheels[1]
        turned = (right - left) / vehicle.track_width
        middle = true.heading + turned / 2.0
        moved = (left + right) / 2.0
        true = Pose2(
            true.x + moved * math.cos(middle), true.y + moved * math.sin(middle), wrap_angle(true.heading + turned)
        )
        log.times.append(now)
        log.poses.append(true)
        log.speeds.append(b.speed)
    log.restarts = follower.restarts
    return follower, committed, log
