"""Wheel reports that the estimator has not yet taken in, because a frame of before may still arrive."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Travel:
    """What both wheels travelled (metres) from `begin` to `end` (seconds); turn: what a gyroscope turned by, if any."""

    begin: float
    end: float
    left: float
    right: float
    turn: float | None = None

    @property
    def still(self) -> bool:
        """Neither wheel has moved, and no gyroscope says otherwise."""
        return self.left == 0.0 and self.right == 0.0 and not self.turn

    def split(self, time: float) -> tuple[Travel | None, Travel | None]:
        """The parts before and after `time`, at even speed."""
        if time <= self.begin:
            return None, self
        if time >= self.end:
            return self, None
        share = (time - self.begin) / (self.end - self.begin)
        turned = None if self.turn is None else share * self.turn
        rest = None if self.turn is None or turned is None else self.turn - turned
        first = Travel(self.begin, time, share * self.left, share * self.right, turned)
        return first, Travel(time, self.end, self.left - first.left, self.right - first.right, rest)


class MotionHistory:
    """Reports in order of time, without gaps; taken off from the front."""

    def __init__(self) -> None:
        self._waiting: deque[Travel] = deque()
        self.newest = -math.inf

    def add(self, time: float, left: float, right: float, turn: float | None = None) -> Travel:
        """A report that ends at `time` and begins where the last one ended."""
        begin = self.newest if math.isfinite(self.newest) else time
        travel = Travel(min(begin, time), time, left, right, turn)
        self._waiting.append(travel)
        self.newest = max(self.newest, time)
        return travel

    def take_until(self, time: float) -> list[Travel]:
        """Removes and returns everything up to `time`, cutting the report that spans it."""
        taken: list[Travel] = []
        while self._waiting:
            before, after = self._waiting[0].split(time)
            if before is None:
                break
            taken.append(before)
            self._waiting.popleft()
            if after is not None:
                self._waiting.appendleft(after)
                break
        return taken

    def until(self, time: float) -> Iterator[Travel]:
        """Everything up to `time`, left where it is."""
        for travel in self._waiting:
            before, _ = travel.split(time)
            if before is None:
                return
            yield before
