"""Motion: paths to constant-jerk segments that the firmware evaluates exactly as they are computed here."""

from rover.motion.committed import CommittedMotion
from rover.motion.follow import PathFollower
from rover.motion.follow_settings import FollowerSettings
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
