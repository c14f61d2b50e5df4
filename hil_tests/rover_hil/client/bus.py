"""A CAN bus on a lock-stepped rig: python-can speaks slcan over the rig's pty, and the rig counts the characters.

slcan writes each frame as a line of text, so the rig's marks (virtual time, bytes sent so far) hold for it as they do
for a serial line.
"""

from __future__ import annotations

import math
import time
from collections import deque

import can
from can.interfaces.slcan import slcanBus
from rover.errors import LinkLost, PreflightFailed
from rover.link.can_bus import (
    BUS_ERRORS,
    GARBLED,
    SEND_TIMEOUT_S,
    bus_bytes,
    bus_time,
    message_of,
    one_line,
    pair_of,
    shut_down,
)
from rover.link.claim import Claim
from rover.link.frames import Counters, Frame, FrameTransport
from rover.link.port import CAN_BITRATE, SLCAN_BAUD, CanPort

from rover_hil.rig import Mark

# Characters of a frame's line around its payload: kind, three of the identifier, length, carriage return.
MIN_LINE_BYTES = 6

# Seconds by which the rigs' adapter sends before the end of a step, less the time until the firmware has the frame
# (firmware/sitl/src/can_adapter.rs).
RELEASE_LEAD_S = 50e-6


class LockstepSlcan(slcanBus):
    """python-can's slcan, counting what it writes, and reading only what the rig has said to be there."""

    def __init__(self, device: str, patience: float) -> None:
        self.bytes_written = 0
        self.bytes_read = 0
        self._patience = patience
        super().__init__(device, tty_baudrate=SLCAN_BAUD, bitrate=CAN_BITRATE, sleep_after_open=0.0, timeout=patience)

    def __del__(self) -> None:
        """Nothing: the rig does not miss a goodbye, and python-can's would complain that the rig is gone."""

    def take(self, total: int) -> None:
        """Reads from the pty until `total` bytes have come in all. Raises LinkLost when they do not."""
        deadline = time.monotonic() + self._patience
        while self.bytes_read < total:
            data = self.serialPortOrig.read(total - self.bytes_read)
            self._buffer += data
            self.bytes_read += len(data)
            if self.bytes_read < total and time.monotonic() > deadline:
                raise LinkLost(f"link lost: {self.bytes_read} of {total} bytes came that the rig sent")

    @property
    def has_line(self) -> bool:
        """True when `recv` has a whole line to read."""
        return self._OK in self._buffer or self._ERROR in self._buffer

    def _write(self, string: str) -> None:
        super()._write(string)
        self.bytes_written += len(string) + len(self.LINE_TERMINATOR)

    def _read(self, timeout: float | None) -> str | None:
        for position, byte in enumerate(self._buffer):
            if bytes([byte]) in (self._OK, self._ERROR):
                line = bytes(self._buffer[: position + 1])
                del self._buffer[: position + 1]
                return line.decode("ascii")
        return None


class LockstepBus(FrameTransport):
    """The rig's pty, read up to the counts that the rig has announced, so the times of frames are virtual."""

    time_step = 0.001

    def __init__(self, port: CanPort, patience: float = 5.0, lead: float = 0.0) -> None:
        """`lead`: seconds after which what is written leaves, see `LockstepRig`. Raises PreflightFailed."""
        self.port = port.name
        self.lead = lead
        self.last_heard = None
        self._marks: deque[Mark] = deque()
        self._received = self._malformed = 0
        self._claim = Claim(port.name)
        try:
            self._bus = LockstepSlcan(port.channel, patience)
        except (*BUS_ERRORS, ValueError) as error:
            self._claim.release()
            raise PreflightFailed(f"cannot open the port {port.name}: {one_line(error)}") from error

    @property
    def bytes_written(self) -> int:
        """Characters, the commands that open the bus among them."""
        return self._bus.bytes_written

    @property
    def bytes_read(self) -> int:
        """Characters."""
        return self._bus.bytes_read

    @property
    def counters(self) -> Counters:
        """`malformed` counts lines that are no frames."""
        return Counters(frames=self._received, malformed=self._malformed)

    def wire_bytes(self, payload: int) -> float:
        """Of the frame on the bus."""
        return bus_bytes(payload)

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """The adapter sends shortly before the end of a step, and hands on at the end of a step what has come.

        The rig's firmware stamps a frame by its last bit, between the steps.
        """
        line = (MIN_LINE_BYTES + 2 * request) * 10.0 / SLCAN_BAUD
        up, down = (math.ceil(seconds / self.time_step) * self.time_step for seconds in (line, bus_time(reply)))
        return up - RELEASE_LEAD_S + bus_time(request), down

    def announce(self, marks: list[Mark]) -> None:
        """Takes the rig's marks (virtual time in µs, bytes sent so far in all)."""
        self._marks.extend(marks)

    def send(self, identifier: int, payload: bytes) -> None:
        """Sends one frame; raises `LinkLost`."""
        try:
            self._bus.send(message_of(identifier, payload), timeout=SEND_TIMEOUT_S)
        except (*BUS_ERRORS, TypeError) as error:
            raise LinkLost(f"link lost: {self.port}: {one_line(error)}") from error

    def receive(self) -> list[Frame]:
        """Frames up to the last mark, each with the time of the mark at which its line ended."""
        frames: list[Frame] = []
        while self._marks:
            time_us, total = self._marks.popleft()
            if total <= self.bytes_read:
                continue
            try:
                self._bus.take(total)
            except (*BUS_ERRORS, TypeError) as error:
                raise LinkLost(f"link lost: {self.port}: {one_line(error)}") from error
            self.last_heard = time_us * 1e-6
            frames += self._lines(self.last_heard)
        self._received += len(frames)
        return frames

    def close(self) -> None:
        """Leaves the bus."""
        shut_down(self._bus)
        self._claim.release()

    def _lines(self, at: float) -> list[Frame]:
        frames: list[Frame] = []
        while self._bus.has_line:
            try:
                message: can.Message | None = self._bus.recv(timeout=0.0)
            except GARBLED:
                self._malformed += 1
                continue
            if message is not None and (pair := pair_of(message)) is not None:
                frames.append(Frame(at, *pair))
        return frames
