"""Wheels by hand: short runs at a speed that a key asks for, which end by themselves when the key is let go.

The rover is armed when the first key is pressed. Every step of 20 ms decides anew: while a key is held the run is
prolonged by as much as is needed to be on its way, and no more. When it is let go, or when nobody calls, the rover
brakes within its limits from what was sent, and the firmware's dead-man stands behind that.
"""

from __future__ import annotations

from dataclasses import dataclass

from rover.link.session import DRIVEABLE, Link
from rover.motion.segment import Segment

# Highest speeds by hand, m/s and rad/s.
MAX_SPEED, MAX_TURNING = 0.15, 0.6
# Seconds without a key after which it counts as let go: terminals repeat a held key after half a second at first.
RELEASE_S = 0.6
# A step of the speed takes twice this many microseconds, at constant jerk.
RAMP_US = 300_000
# Cruising goes on in pieces of this length, sent when less than HORIZON_S is left.
PIECE_US = 60_000
HORIZON_S = 0.12
START_S = 0.08


@dataclass(frozen=True)
class Wish:
    """Speed along (m/s) and about (rad/s)."""

    travel: float
    heading: float

    @property
    def still(self) -> bool:
        """Nothing is to move."""
        return self.travel == 0.0 and self.heading == 0.0


STILL = Wish(0.0, 0.0)


def ramp(change: Wish, half_us: int = RAMP_US) -> list[Segment]:
    """Two segments of equal and opposite jerk, `half_us` each, that change the speed by that much."""
    seconds = half_us * 1e-6
    travel, heading = (round(value / seconds**2 * 1e6) for value in (change.travel, change.heading))
    return [Segment(half_us, travel, heading), Segment(half_us, -travel, -heading)]


class Jog:
    """Streams what the keys want. Call `step` every 20 ms."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._wanted = self._now = STILL
        self._asked_at = -1.0

    @property
    def wanted(self) -> Wish:
        """What the keys ask for now."""
        return self._wanted

    def ask(self, wish: Wish) -> None:
        """A key is pressed, or is still held."""
        self._wanted, self._asked_at = wish, self._link.clock.now()

    def release(self) -> None:
        """Nothing is to move any more."""
        self._wanted = STILL

    def step(self) -> None:
        """Arms, begins, prolongs or ends the run. Raises PreflightFailed when the firmware does not arm, LinkLost."""
        link = self._link
        now = link.clock.now()
        if now - self._asked_at > RELEASE_S:
            self._wanted = STILL
        state = link.state
        if state is None or state.state not in DRIVEABLE:
            self._now = STILL
            if self._wanted.still:
                return
            link.arm()
            now = link.clock.now()
            self._asked_at = now
        stream = link.stream
        if not self._now.still:
            if stream.end_time < now + HORIZON_S:
                self._prolong()
        elif not self._wanted.still and stream.all_done:
            stream.begin(_begun(ramp(self._wanted)), now + START_S)
            self._now = self._wanted

    def _prolong(self) -> None:
        """The same again, or to rest when something else is wanted."""
        if self._wanted == self._now:
            self._link.stream.extend([Segment(PIECE_US, 0, 0)])
            return
        down, level = ramp(Wish(-self._now.travel, -self._now.heading))
        self._link.stream.extend([down, _rested(level)])
        self._now = STILL


def _begun(segments: list[Segment]) -> list[Segment]:
    first = segments[0]
    return [Segment(first.duration_us, first.jerk_travel, first.jerk_heading, begin=True), *segments[1:]]


def _rested(segment: Segment) -> Segment:
    return Segment(segment.duration_us, segment.jerk_travel, segment.jerk_heading, rest=True)
