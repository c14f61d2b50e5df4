"""Motion for a test of the link: turns on the spot, cut into short segments, each turn by an angle of its own."""

from __future__ import annotations

import math

import numpy as np

from rover.link.telemetry import MotionStatus, ReferenceDistance
from rover.link.unwrap import ahead
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, to_position
from rover.motion.segment import Segment, State, end_state, split
from rover.vehicle import Vehicle

MIN_TURN = math.radians(3.0)
MAX_TURN = math.radians(9.0)
# Longest of the segments: fifty a second, many more than a mission's seven for each leg.
MAX_PIECE_US = 20_000

# Radians: sums of exact integers that are reported to 1e-6. Turns differ from each other by much more.
TOLERANCE_RAD = 5e-6

Turn = list[Segment]


def turns(count: int, rng: np.random.Generator) -> list[Turn]:
    """`count` turns to the left and to the right in turn, so that the rover stays where it is."""
    angles = rng.uniform(MIN_TURN, MAX_TURN, count)
    return [
        split(run(merge(None, to_position(Axis(), float(angle) * (-1) ** number, Vehicle().heading))), MAX_PIECE_US)
        for number, angle in enumerate(angles)
    ]


def angle_of(turn: Turn) -> float:
    """Radians that a turn turns by, exactly as the firmware evaluates it."""
    return end_state(turn, State()).heading


def compare(block: list[Turn], turned: float) -> tuple[int, int]:
    """(lost, repeated) segments of a block of turns after which the firmware says that it has turned by `turned`.

    A missing or doubled segment inside a turn cannot stay unseen: the turn would not end at rest, and is refused.
    So a difference is a turn that is missing or doubled; one that is neither counts as the whole block lost.
    """
    difference = turned - sum(map(angle_of, block))
    if abs(difference) <= TOLERANCE_RAD:
        return 0, 0
    for turn in block:
        if abs(difference + angle_of(turn)) <= TOLERANCE_RAD:
            return len(turn), 0
        if abs(difference - angle_of(turn)) <= TOLERANCE_RAD:
            return 0, len(turn)
    return sum(map(len, block)), 0


class Executed:
    """What the firmware has executed, by its own account."""

    def __init__(self) -> None:
        self.reference: ReferenceDistance | None = None
        self.status: MotionStatus | None = None
        self._first: int | None = None

    def take(self, event: object) -> None:
        """Any telemetry, in any order; of two of a kind the later one holds."""
        if isinstance(event, ReferenceDistance) and (self.reference is None or event.time >= self.reference.time):
            self.reference = event
        if isinstance(event, MotionStatus) and (self.status is None or event.time >= self.status.time):
            self.status = event

    def begin(self) -> None:
        """Segments count from here on; call when nothing moves and the first status is there."""
        assert self.status is not None
        self._first = self.status.next_index

    def count(self, sent: int) -> int:
        """Segments executed of the `sent` ones, by the index that ran last; call when the queue has run dry."""
        if self.status is None or self._first is None:
            return 0
        expected = (self._first + sent - 1) & 0xFFFF
        return sent + ahead(self.status.executing, expected)
