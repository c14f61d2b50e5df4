"""The host's CAN adapter in lock step: whatever SPI costs, frames are sent and handed over in declared ticks.

The same rules as in firmware/sitl/src/can_adapter.rs: two frames a millisecond go on the bus, and what the firmware has
said in one tick is the host's in the next one.
"""

from __future__ import annotations

from collections import deque
from typing import Any

from rover_hil.emulator.can_bus import CanBus, Frame
from rover_hil.emulator.slcan import MAX_WAITING, REFUSED, SlcanAdapter, parse_frame

# The firmware sends as many (firmware/pico/src/can.rs): with four of them the bus is full.
FRAMES_PER_TICK = 2
# From the opening until the adapter sends: a board that was switched on with it listens by then, after 1.8 ms.
OPENING_TICKS = 3


class PacedAdapter(SlcanAdapter):
    """`release` once a millisecond, when the host's frames go on the bus; `hand_over` at its end."""

    def __init__(self, bus: CanBus, clock: Any) -> None:
        """`clock`: rover_plant's."""
        super().__init__(bus)
        self._clock = clock
        self._held: deque[Frame] = deque()
        self._heard: deque[tuple[int, Frame]] = deque()
        self._opening = 0

    def heard(self, frame: Frame) -> None:
        """Kept with the cycle of its last bit."""
        self._heard.append((self._clock.cycles, frame))

    def release(self) -> None:
        """What has come first goes on the bus, as far as the adapter has room there."""
        if self._opening:
            self._opening -= 1
            return
        while self._held and len(self._waiting) < FRAMES_PER_TICK:
            self._waiting.append(self._held.popleft())
        if self._waiting:
            self._bus.request()

    def hand_over(self, before: int) -> bytes:
        """Lines for the host: frames that ended before that cycle, the lowest identifier first, then the answers.

        The order in which the controller happened to get the frames of a tick is not told."""
        passed: list[Frame] = []
        while self._heard and self._heard[0][0] < before:
            passed.append(self._heard.popleft()[1])
        passed.sort(key=lambda frame: frame.arbitration)
        lines = b"".join(map(self._text, passed)) + bytes(self.answers)
        self.answers.clear()
        return lines

    def _execute(self, line: bytes) -> bytes:
        if line == b"O":
            self._opening = OPENING_TICKS
        elif line == b"C":
            self._held.clear()
        return super()._execute(line)

    def _transmit(self, line: bytes) -> bytes:
        frame = parse_frame(line)
        if frame is None or not self._open or len(self._held) >= MAX_WAITING:
            return REFUSED
        self._held.append(frame)
        return b""
