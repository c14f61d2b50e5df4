"""What a mission finds wrong by itself, from what comes in: shares over the last while, with the limits beside them.

All of it is computed from what a log holds, so a replay finds the same.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from statistics import median

from rover.link.telemetry import LinkQuality, Telemetry
from rover.mission.fault_table import Check
from rover.vision.localization.fix import Fix

# Pictures over which refusals and residuals are judged: six seconds.
FIXES = 50
REFUSED_SHARE = 0.6
# Residual that the registration has on ground that it knows is 0.7 px; beyond 2.5 px points are no inliers any more.
RESIDUAL_PX = 1.3
# How far the camera shows the ground off where it is, metres and standard deviations, from which its file is wrong.
OFFSET_M = 0.008
OFFSET_SIGMAS = 4.0
# Cycles over which lateness is judged: ten seconds.
CYCLES = 500
LATE_S = 0.035
LATE_SHARE = 0.5
# Share of frames that the firmware lost or could not read, between reports this many seconds apart or more.
WIRE_SHARE = 0.2
WIRE_PERIOD_S = 2.0
# What the clocks may be apart, seconds: 1 cm at full speed.
CLOCK_S = 0.04
# Commanded travel of the wheels within RESPONSE_S of which at least RESPONSE_SHARE must have come.
RESPONSE_S = 2.0
RESPONSE_M = 0.05
RESPONSE_SHARE = 0.1


class Checks:
    """`active` after each cycle: what is wrong now. Times are seconds of the companion's clock."""

    def __init__(self, late_s: float = LATE_S) -> None:
        """`late_s`: between two cycles, from which the second counts as late."""
        self._late_s = late_s
        self.active: set[Check] = set()
        # What is known beyond the row's line, for the operator.
        self.details: dict[Check, str] = {}
        self._fixes: deque[Fix] = deque(maxlen=FIXES)
        self._late: deque[bool] = deque(maxlen=CYCLES)
        self._before: float | None = None
        self._quality: LinkQuality | None = None
        self._way: deque[tuple[float, float, float]] = deque()

    def take(self, now: float, telemetry: Sequence[Telemetry], fix: Fix | None) -> None:
        """One cycle. `fix`: what became of its picture, None without one that shows ground."""
        if self._before is not None:
            self._late.append(now - self._before > self._late_s)
            share = sum(self._late) / len(self._late)
            self._set(Check.LATE_CYCLES, len(self._late) == CYCLES and share > LATE_SHARE)
        self._before = now
        if fix is not None:
            self._fixes.append(fix)
            self._judge_fixes()
        for event in telemetry:
            if isinstance(event, LinkQuality):
                self._judge_wire(event)

    def clock(self, error_bound: float) -> None:
        """What the clock estimate may be off by, seconds."""
        self._set(Check.CLOCK, error_bound > CLOCK_S)

    def kept(self, trouble: str | None) -> None:
        """`trouble`: why what has been recorded and learned can be kept no more; None while it can."""
        self._set(Check.LOG, trouble is not None)
        if trouble is not None:
            self.details[Check.LOG] = trouble

    def moved(self, now: float, commanded: Callable[[float, float], float], travelled: float) -> None:
        """`commanded`: metres that the wheels were to roll between two times; `travelled`: that they have in all."""
        way = self._way
        way.append((now, way[-1][1] + commanded(way[-1][0], now) if way else 0.0, travelled))
        while now - way[0][0] > RESPONSE_S:
            way.popleft()
        wanted, came = way[-1][1] - way[0][1], way[-1][2] - way[0][2]
        self._set(Check.NO_MOTION, wanted > RESPONSE_M and came < RESPONSE_SHARE * wanted and self._steady(wanted))

    def stands(self) -> None:
        """Whatever was commanded is void: the firmware has stopped the rover."""
        self._way.clear()
        self._set(Check.NO_MOTION, False)

    def _steady(self, wanted: float) -> bool:
        """Most of the way was wanted long enough ago for the wheels to have answered."""
        now, middle = self._way[-1][0], self._way[0][1] + 0.5 * wanted
        return any(total >= middle and now - at > 0.5 * RESPONSE_S for at, total, _ in self._way)

    def _judge_fixes(self) -> None:
        full = len(self._fixes) == FIXES
        refused = sum(not fix.accepted for fix in self._fixes)
        self._set(Check.FIXES_REFUSED, full and refused > REFUSED_SHARE * FIXES)
        good = [fix.residual_px for fix in self._fixes if fix.accepted and fix.inliers > 0]
        fits_badly = len(good) > 0.4 * FIXES and median(good) > RESIDUAL_PX
        last = self._fixes[-1]
        sits_otherwise = last.offset > max(OFFSET_M, OFFSET_SIGMAS * last.offset_sigma)
        self._set(Check.MOUNT_RESIDUAL, fits_badly or sits_otherwise)

    def _judge_wire(self, quality: LinkQuality) -> None:
        before = self._quality
        if before is None:
            self._quality = quality
        elif quality.time - before.time >= WIRE_PERIOD_S:
            self._quality = quality
            bad = sum(
                now - then
                for now, then in (
                    (quality.lost, before.lost),
                    (quality.checksum_errors, before.checksum_errors),
                    (quality.malformed, before.malformed),
                )
            )
            good = quality.frames - before.frames
            self._set(Check.WIRE_ERRORS, bad > WIRE_SHARE * max(good + bad, 1))

    def _set(self, check: Check, active: bool) -> None:
        if active:
            self.active.add(check)
        else:
            self.active.discard(check)
