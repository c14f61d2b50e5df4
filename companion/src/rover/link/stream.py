"""Streams constant-jerk segments into the firmware's queue: indexed, acknowledged, repeated.

The firmware takes segments strictly in order and says which index it expects next and how much room it has; what
comes early it keeps. Each segment that is not acknowledged in time is sent again, the oldest first. Duplicates do no
harm: the firmware ignores them.

A run is a row of segments that begins at rest at a given time; its first segment carries the begin flag. After a stop
the firmware has thrown its queue away, so the stream starts again from the index that the firmware names, once what
was still on the wire has settled.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from rover.link.clock_estimate import ClockEstimate
from rover.link.telemetry import MotionStatus
from rover.link.unwrap import ahead

FLAG_BEGIN = 1
FLAG_REST = 2
# Seconds after which an unacknowledged segment is sent again: the acknowledgement takes one loop of 20 ms, or two
# where the world runs a step ahead, and a third at most on a busy wire.
REPEAT_AFTER_S = 0.07

# Seconds after the last segment sent until a status surely tells of all that the firmware took.
SETTLE_S = 0.2

# Segments sent in one go: about 230 bytes, half of what the wire carries in a 20 ms loop.
MAX_BURST = 8

# Segments sent and not acknowledged, at most.
MAX_IN_FLIGHT = 24

# An acknowledgement up to this many indexes behind is an old one that came late: it takes nothing back.
MAX_STALE = 256

# Seconds ahead of its start time at which a run must be on its way.
MIN_START_LEAD_S = 0.04

# Seconds from now at which a run starts that missed its time.
START_DELAY_S = 0.15

# Period at which the firmware moves its reference.
TICK_US = 1000

Send = Callable[..., object]


class SegmentLike(Protocol):
    """A quantised segment as `rover.motion` makes it."""

    @property
    def duration_us(self) -> int: ...
    @property
    def jerk_travel(self) -> int: ...
    @property
    def jerk_heading(self) -> int: ...
    @property
    def rest(self) -> bool: ...


@dataclass
class _Item:
    segment: SegmentLike
    begin: bool
    start: float
    """Companion time at which the run starts; of begin segments only."""
    sent_at: float | None = None
    """Companion time of the last transmission."""
    due: bool = True
    """Waits for a transmission, however short ago the last one was."""


class SegmentStream:
    """Outgoing segments and their acknowledgement. Call `service` once per loop."""

    def __init__(self, send: Send, clock: ClockEstimate) -> None:
        """`send(message name, **raw fields)` puts one message on the wire."""
        self._send = send
        self._clock = clock
        self._items: deque[_Item] = deque()
        self._base: int | None = None
        # Of the waiting segments, counted from the oldest: those that have been on the wire under their index.
        self._exposed = 0
        self._settled_after: float | None = None
        self._last_sent_at = 0.0
        self.status: MotionStatus | None = None
        self.sent = 0
        self.repeated = 0
        self.accepted = 0
        self.postponed = 0
        """Runs whose start time had passed before the firmware had them, and that were given a later one."""
        self.end_time = 0.0
        """Companion time at which everything submitted so far has run."""

    @property
    def executing(self) -> int | None:
        """Wire index of the segment that runs now or ran last; None before the first status."""
        return None if self.status is None else self.status.executing

    @property
    def all_done(self) -> bool:
        """True when nothing waits here and the firmware's queue has run dry."""
        return not self._items and (self.status is None or self.status.queued == 0)

    @property
    def unacknowledged(self) -> int:
        """Segments submitted and not yet taken by the firmware."""
        return len(self._items)

    def begin(self, segments: Sequence[SegmentLike], start: float) -> float:
        """Submits a run that starts from rest at companion time `start`; returns the time at which it ends."""
        start = max(start, self.end_time)
        for position, segment in enumerate(segments):
            self._items.append(_Item(segment, position == 0, start))
        self.end_time = start + _duration(segments)
        return self.end_time

    def extend(self, segments: Sequence[SegmentLike]) -> float:
        """Appends to the run that was begun last; returns the time at which it now ends."""
        for segment in segments:
            self._items.append(_Item(segment, False, 0.0))
        self.end_time += _duration(segments)
        return self.end_time

    def clear(self, now: float) -> None:
        """Forgets what was not acknowledged: after a stop, a latch or a disarm, when the firmware's queue is gone."""
        if self._exposed:
            self._settled_after = self._last_sent_at + SETTLE_S
        self._items.clear()
        self._exposed = 0
        self.end_time = now

    def on_status(self, status: MotionStatus) -> None:
        """Takes an acknowledgement."""
        self.status = status
        if self._settled_after is not None:
            if status.time < self._settled_after:
                return
            self._settled_after = None
            self._base = status.next_index
        if self._base is None:
            self._base = status.next_index
        advance = ahead(status.next_index, self._base)
        if 0 < advance <= self._exposed:
            for _ in range(advance):
                self._items.popleft()
            self._exposed -= advance
            self._base = status.next_index
            self.accepted += advance
        elif advance > 0 or advance < -MAX_STALE:
            # The firmware counts from elsewhere (it has restarted): what waits takes the indexes that it expects.
            self._base = status.next_index
            self._exposed = 0
            for item in self._items:
                item.due = True

    def service(self, now: float) -> None:
        """Sends what fits, repeats what is overdue."""
        if self._base is None or self.status is None or self._settled_after is not None:
            return
        if self._items and _is_due(self._items[0], now):
            self._postpone_missed_start(now)
        room = min(len(self._items), ahead(self.status.next_index, self._base) + self.status.free_slots, MAX_IN_FLIGHT)
        due = [position for position in range(room) if _is_due(self._items[position], now)]
        for position in due[:MAX_BURST]:
            self._transmit(position, now)
            self._exposed = max(self._exposed, position + 1)

    def _transmit(self, position: int, now: float) -> None:
        assert self._base is not None
        item = self._items[position]
        index = (self._base + position) & 0xFFFF
        if item.begin:
            # The firmware's ticks lie on whole milliseconds of its clock.
            start_us = round(self._clock.to_firmware(item.start) / TICK_US) * TICK_US & 0xFFFF_FFFF
            self._send("SegmentStart", index=index, start_time=start_us)
        segment = item.segment
        flags = (FLAG_BEGIN if item.begin else 0) | (FLAG_REST if segment.rest else 0)
        self._send("SegmentTravel", index=index, duration=segment.duration_us, jerk_travel=segment.jerk_travel)
        self._send("SegmentHeading", index=index, jerk_heading=segment.jerk_heading, flags=flags)
        if item.sent_at is None:
            self.sent += 1
        else:
            self.repeated += 1
        item.sent_at = now
        item.due = False
        self._last_sent_at = now

    def _postpone_missed_start(self, now: float) -> None:
        """A begin segment is refused once its time has passed. The rover stands, so the run may start later."""
        item = self._items[0]
        if not item.begin or item.start >= now + MIN_START_LEAD_S:
            return
        delay = now + START_DELAY_S - item.start
        for waiting in self._items:
            if waiting.begin:
                waiting.start += delay
                waiting.due = True
        self.end_time += delay
        self.postponed += 1


def _is_due(item: _Item, now: float) -> bool:
    """True when an item waits to be sent, or should have been acknowledged by now."""
    return item.due or item.sent_at is None or now - item.sent_at > REPEAT_AFTER_S


def _duration(segments: Sequence[SegmentLike]) -> float:
    return sum(segment.duration_us for segment in segments) * 1e-6
