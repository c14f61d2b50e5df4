"""Kidnapped and restarted: a rover that is put somewhere else, or starts with keyframes and no idea where it stands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from rover.geometry import Pose2
from rover.vision.localization.localizer import Localizer

from tools.bench.vision.drives import FRAME_STEPS, Scene
from tools.bench.vision.way import STEP_M, Drive

# Frames shown after each kidnap; the rover stands meanwhile.
FRAMES = 8
RIGHT_M, RIGHT_DEG = 0.10, 5.0
ASIDE_M, ASIDE_RAD = 0.05, 0.2
# Nearer than this to where it is believed to be is no kidnap.
AWAY_M = 0.5


@dataclass
class Outcome:
    """frames: until found, one entry for each kidnap that was found right. lost: it says so. wrong: placed wrongly.

    unnoticed: neither lost nor found.
    """

    frames: list[int] = field(default_factory=list)
    lost: int = 0
    wrong: int = 0
    unnoticed: int = 0

    @property
    def tried(self) -> int:
        """All kidnaps."""
        return len(self.frames) + self.lost + self.wrong + self.unnoticed


def somewhere(at: Scene, drive: Drive, known: bool) -> Pose2 | None:
    """A pose beside one that was driven, or one whose ground no driven pose has shown; None when hard to find."""
    width, depth = at.field.ground.area
    seen = at.field.ground.obstacles.tolist()
    for _ in range(200):
        if known:
            pose = drive.poses[int(at.rng.integers(len(drive.poses)))]
            dx, dy, turn = (at.rng.uniform(-1.0, 1.0, 3) * (ASIDE_M, ASIDE_M, ASIDE_RAD)).tolist()
            pose = Pose2(pose.x + dx, pose.y + dy, pose.heading + turn)
        else:
            x, y = at.rng.uniform(0.0, (width, depth)).tolist()
            pose = Pose2(x, y, float(at.rng.uniform(-math.pi, math.pi)))
            centre = pose.transform(np.array([[0.7, 0.0]]))[0]
            looked = np.array([p.transform(np.array([[0.7, 0.0]]))[0] for p in drive.poses[::25]])
            if np.hypot(*(looked - centre).T).min() < 0.9:
                continue
        if all(math.hypot(pose.x - x, pose.y - y) > r + 0.2 for x, y, r, _ in seen):
            return pose
    return None


def kidnap(at: Scene, drive: Drive, localizer: Localizer, times: int, known: bool, step: int) -> tuple[Outcome, int]:
    """Puts the rover somewhere else `times` times from `step` on; what became of it, and the step reached."""
    outcome = Outcome()
    for _ in range(times):
        pose = somewhere(at, drive, known)
        if pose is None or pose.distance(localizer.pose) < AWAY_M:
            continue
        found = 0
        for count in range(1, FRAMES + 1):
            step += FRAME_STEPS
            localizer.predict(step * STEP_M, 0.0, 0.0)
            fix = localizer.observe(at.frame(pose, step))
            if fix.reason == "relocated" and not found:
                found = count
        off = localizer.pose.distance(pose)
        turned = abs(math.degrees(math.remainder(localizer.pose.heading - pose.heading, 2.0 * math.pi)))
        if off <= RIGHT_M and turned <= RIGHT_DEG:
            outcome.frames.append(found or 1)
        elif localizer.lost:
            outcome.lost += 1
        elif found:
            outcome.wrong += 1
        else:
            outcome.unnoticed += 1
    return outcome, step
