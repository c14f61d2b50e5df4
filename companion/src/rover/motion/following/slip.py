"""How the ground differs from what the wheels were told: learned from the pose estimates while driving."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rover.geometry import Pose2, wrap_angle
from rover.motion.following.committed import CommittedMotion


@dataclass
class SlipEstimate:
    """What the ground makes of commanded motion.

    `scale`: metres per metre of travel; `drift`: radians per metre of travel; `turn`: radians per radian turned.
    """

    scale: float = 1.0
    drift: float = 0.0
    turn: float = 1.0

    # A window this long keeps the noise of the estimates (1 cm, 0.01 rad) well below what is learned.
    window_m = 0.25
    gain_scale = 0.2
    gain_drift = 0.5
    gain_turn = 0.3

    _since: tuple[float, Pose2] | None = None

    def restart(self) -> None:
        """Forgets the running window; what was learned stays."""
        self._since = None

    def driving(self, now: float, pose: Pose2, committed: CommittedMotion, curved: bool = False) -> None:
        """Called with each estimate while driving; learns once per window.

        `curved`: the path turns here, and what is turned tells nothing of the drift.
        """
        if self._since is None:
            self._since = (now, pose)
            return
        time, before = self._since
        a, b = committed.state_at(time), committed.state_at(now)
        travel = b.travel - a.travel
        if travel < self.window_m:
            return
        turned = wrap_angle(pose.heading - before.heading)
        middle = before.heading + 0.5 * turned
        ground = (pose.x - before.x) * math.cos(middle) + (pose.y - before.y) * math.sin(middle)
        commanded = b.heading - a.heading
        drift = (turned - commanded) / travel
        self.scale += self.gain_scale * (min(max(ground / travel, 0.8), 1.1) - self.scale)
        if not curved:
            self.drift += self.gain_drift * (min(max(drift, -0.6), 0.6) - self.drift)
        elif abs(commanded) > 0.3:
            turn = (turned - self.drift * travel) / commanded
            self.turn += self.gain_turn * (min(max(turn, 0.7), 1.15) - self.turn)
        self._since = (now, pose)

    def turned(self, commanded: float, observed: float) -> None:
        """Called after a turn on the spot that was large enough to tell (radians)."""
        if abs(commanded) > 0.4:
            self.turn += 0.5 * (min(max(observed / commanded, 0.7), 1.15) - self.turn)
