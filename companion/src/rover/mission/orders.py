"""What a survey asks of its caller."""

from __future__ import annotations

from dataclasses import dataclass, field

from rover.motion.segment import Segment


@dataclass(frozen=True)
class Orders:
    """What the caller has to do now. start: when the run that these segments begin starts. stop: by the firmware."""

    segments: list[Segment] = field(default_factory=list)
    start: float | None = None
    arm: bool = False
    stop: bool = False
