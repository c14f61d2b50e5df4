"""Motion: paths to constant-jerk segments that the firmware evaluates exactly as they are computed here."""

from rover.motion.following.committed import CommittedMotion
from rover.motion.following.follower import PathFollower
from rover.motion.following.settings import FollowerSettings
from rover.motion.segment import Segment, State, evaluate
from rover.motion.stop import stop_segments

__all__ = [
    "CommittedMotion",
    "FollowerSettings",
    "PathFollower",
    "Segment",
    "State",
    "evaluate",
    "stop_segments",
]
