"""What the inertial sensor finds beyond driving: wheels that slip, slopes, somebody's hands, a rover on its side.

Each is a check of the mission's table of faults. All of it needs the sensor; without one nothing is ever found.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

from rover.link.telemetry import Gravity, Telemetry, Turned, WheelMotion
from rover.mission.fault_table import Check
from rover.vehicle import Vehicle

# Wheels and gyroscope disagree about the turn of the last while by more than this: radians, seconds.
SLIP_RAD = 0.15
SLIP_S = 1.5
# A lean lasts so long before it is a slope and no bump, seconds; it is over when it is less by this, radians.
SLOPE_S = 0.3
SLOPE_BACK = math.radians(2.0)
# Leaning more than this, radians, is lying.
TIPPED = math.radians(60.0)
# Nobody holds a thing still: the vertical sways by this rate on average over so long, rad/s and seconds. Ground that is
# driven over at full speed, 2° rms, sways it by a quarter of that.
SWAY = 0.2
SWAY_S = 0.5
# Wheels stand and the rover turns by this, radians, within SWAY_S.
CARRIED_RAD = 0.1
# Swaying less than this for so long, rad/s and seconds, it has been set down.
SET_DOWN = 0.05
SET_DOWN_S = 1.0
# Wheels stand that roll less than this within SWAY_S, metres.
STANDING_M = 0.002


class Handling:
    """`active` after each cycle's telemetry."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.active: set[Check] = set()
        self._vehicle = vehicle
        # Times with what the gyroscope and the wheels have turned by and the wheels have rolled so far.
        self._turned: deque[tuple[float, ...]] = deque()
        self._rolled: deque[tuple[float, ...]] = deque()
        self._up: deque[Gravity] = deque()
        self._steep_since: float | None = None
        self._still_since: float | None = None

    def take(self, event: Telemetry) -> None:
        """One piece of telemetry, of whatever kind."""
        if isinstance(event, Turned):
            _push(self._turned, (event.time, event.heading), SLIP_S)
        elif isinstance(event, WheelMotion):
            scales = self._vehicle.wheel_scales
            left, right = scales[0] * event.left_counts, scales[1] * event.right_counts
            turn = (right - left) / self._vehicle.track_width
            _push(self._rolled, (event.time, turn, 0.5 * (left + right)), SLIP_S)
            self._judge_turns(event.time)
        elif isinstance(event, Gravity):
            self._judge_lean(event)

    def _judge_turns(self, now: float) -> None:
        if not self._turned or now - self._turned[-1][0] > SWAY_S:
            self._set(Check.SLIPPING, False)
            return
        turned, rolled = _change(self._turned, SLIP_S), _change(self._rolled, SLIP_S)
        self._set(Check.SLIPPING, abs(turned - rolled) > SLIP_RAD and Check.HANDLED not in self.active)
        way = abs(_change(self._rolled, SWAY_S, 2)) + abs(_change(self._rolled, SWAY_S)) * self._vehicle.track_width
        if way < STANDING_M and abs(_change(self._turned, SWAY_S)) > CARRIED_RAD:
            self._handle()

    def _judge_lean(self, event: Gravity) -> None:
        if event.status == "Lost":
            self._up.clear()
            return
        self._up.append(event)
        while event.time - self._up[0].time > SWAY_S:
            self._up.popleft()
        lean = _angle(event, Gravity(0.0, 0.0, 0.0, 1.0, 0.0, ""))
        self._set(Check.TIPPED, lean > TIPPED)
        limit = self._vehicle.max_slope
        if lean <= limit - SLOPE_BACK:
            self._steep_since = None
            self._set(Check.STEEP, False)
        elif lean > limit:
            self._steep_since = event.time if self._steep_since is None else self._steep_since
            if event.time - self._steep_since >= SLOPE_S:
                self._set(Check.STEEP, True)
        self._judge_sway(event.time)

    def _judge_sway(self, now: float) -> None:
        covered = now - self._up[0].time
        if covered < 0.8 * SWAY_S:
            return
        up = list(self._up)
        rate = sum(_angle(a, b) for a, b in pairwise(up)) / covered
        if rate > SWAY:
            self._handle()
        if rate > SET_DOWN:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = now
        elif now - self._still_since > SET_DOWN_S:
            self._set(Check.HANDLED, False)

    def _handle(self) -> None:
        self._still_since = None
        self._set(Check.HANDLED, True)

    def _set(self, check: Check, active: bool) -> None:
        (self.active.add if active else self.active.discard)(check)


def _push(history: deque[tuple[float, ...]], entry: tuple[float, ...], seconds: float) -> None:
    """Keeps a little more than so many seconds; a gap begins anew."""
    if history and not 0.0 <= entry[0] - history[-1][0] < seconds:
        history.clear()
    history.append(entry)
    while len(history) > 2 and entry[0] - history[1][0] > seconds:
        history.popleft()


def _change(history: deque[tuple[float, ...]], seconds: float, column: int = 1) -> float:
    """Of a column over the last so many seconds."""
    if not history:
        return 0.0
    first = next(entry for entry in history if history[-1][0] - entry[0] <= seconds)
    return history[-1][column] - first[column]


def _angle(a: Gravity, b: Gravity) -> float:
    """Between two verticals, radians."""
    cross = (a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
    return math.atan2(math.hypot(*cross), a.x * b.x + a.y * b.y + a.z * b.z)
