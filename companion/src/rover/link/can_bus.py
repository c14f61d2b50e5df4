"""A CAN bus through python-can: one classic frame for each message, with nothing of ours around it."""

from __future__ import annotations

import os
import threading
from collections import deque
from typing import Any

import can

from rover.errors import LinkLost, PreflightFailed
from rover.link.claim import Claim
from rover.link.clock import WallClock
from rover.link.frames import Counters, Frame, FrameTransport
from rover.link.port import CAN_BITRATE, CAN_FRAME_BITS, CanPort

# Seconds until a bus that takes no frame counts as lost.
SEND_TIMEOUT_S = 2.0

# What python-can's interfaces raise when the bus or its adapter is gone.
BUS_ERRORS = (can.CanError, OSError)

# What slcan raises for a line that is no frame.
GARBLED = (ValueError, IndexError)


class CanTransport(FrameTransport):
    """A real bus: a thread reads it and stamps each frame with `clock`."""

    time_step = 0.0
    lead = 0.0

    def __init__(self, port: CanPort, clock: WallClock | None = None) -> None:
        """Raises PreflightFailed with one line when the bus does not open."""
        self.port = port.name
        self.last_heard = None
        self._claim = Claim(port.name)
        try:
            self._bus = open_bus(port)
        except PreflightFailed:
            self._claim.release()
            raise
        self._clock = clock or WallClock()
        self._frames: deque[Frame] = deque()
        self._received = self._malformed = 0
        self._written = self._read = 0.0
        self._failure: str | None = None
        self._closing = False
        self._reader = threading.Thread(target=self._read_forever, name="can-reader", daemon=True)
        self._reader.start()

    @property
    def bytes_written(self) -> int:
        """Of whole frames, on the bus."""
        return round(self._written)

    @property
    def bytes_read(self) -> int:
        """Of whole frames, on the bus."""
        return round(self._read)

    @property
    def counters(self) -> Counters:
        """A frame that a CAN controller found wrong never gets here; `malformed` counts what an adapter garbled."""
        return Counters(frames=self._received, malformed=self._malformed)

    def wire_bytes(self, payload: int) -> float:
        """Without the bits that the bus stuffs in: commonly a twentieth more, at most a fifth."""
        return bus_bytes(payload)

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """By the bit rate."""
        return bus_time(request), bus_time(reply)

    def send(self, identifier: int, payload: bytes) -> None:
        """Sends one frame; raises `LinkLost`."""
        if self._failure is not None:
            raise LinkLost(self._failure)
        try:
            self._bus.send(message_of(identifier, payload), timeout=SEND_TIMEOUT_S)
        except (*BUS_ERRORS, TypeError) as error:  # a serial adapter that was closed meanwhile raises TypeError
            raise LinkLost(f"link lost: {self.port}: {one_line(error)}") from error
        self._written += self.wire_bytes(len(payload))

    def receive(self) -> list[Frame]:
        """Frames since the last call; raises `LinkLost` once everything read before the failure is delivered."""
        frames: list[Frame] = []
        while self._frames:
            frames.append(self._frames.popleft())
        if not frames and self._failure is not None:
            raise LinkLost(self._failure)
        self._received += len(frames)
        self._read += sum(bus_bytes(len(frame.payload)) for frame in frames)
        if frames:
            self.last_heard = frames[-1].time
        return frames

    def close(self) -> None:
        """Ends the reader and leaves the bus."""
        self._closing = True
        if self._reader is not threading.current_thread():
            self._reader.join(timeout=1.0)
        shut_down(self._bus)
        self._claim.release()

    def _read_forever(self) -> None:
        while not self._closing:
            try:
                message = self._bus.recv(timeout=0.05)
            except GARBLED:
                self._malformed += 1
                continue
            except (*BUS_ERRORS, TypeError) as error:
                if not self._closing:
                    self._failure = f"link lost: {self.port}: {one_line(error)}"
                return
            if message is not None and (pair := pair_of(message)) is not None:
                self._frames.append(Frame(self._clock.now(), *pair))


def bus_bytes(payload: int) -> float:
    """Length of a frame in bytes, without the bits that are stuffed in."""
    return CAN_FRAME_BITS / 8.0 + payload


def bus_time(payload: int) -> float:
    """Seconds that a frame takes on the bus."""
    return bus_bytes(payload) * 8.0 / CAN_BITRATE


def open_bus(port: CanPort) -> can.BusABC:
    """The bus behind a port. Raises PreflightFailed with one line when there is none."""
    options: dict[str, Any] = {"bitrate": CAN_BITRATE}
    if port.interface == "slcan" and os.path.realpath(port.channel).startswith("/dev/pts/"):
        options["sleep_after_open"] = 0.0  # a pseudo-terminal has no adapter behind it that restarts on opening
    try:
        return can.Bus(interface=port.interface, channel=port.channel, **options)
    except (*BUS_ERRORS, ValueError, TypeError, ImportError, AttributeError) as error:
        raise PreflightFailed(f"cannot open the port {port.name}: {one_line(error)}") from error


def message_of(identifier: int, payload: bytes) -> can.Message:
    """A classic frame with an 11-bit identifier."""
    return can.Message(arbitration_id=identifier, data=payload, is_extended_id=False)


def pair_of(message: can.Message) -> tuple[int, bytes] | None:
    """Identifier and payload; None for what this protocol does not use: other frames of a shared bus."""
    if message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd:
        return None
    return message.arbitration_id, bytes(message.data)


def shut_down(bus: can.BusABC) -> None:
    """Leaves the bus; an adapter that is gone already has nothing left to close."""
    try:
        bus.shutdown()
    except (*BUS_ERRORS, TypeError):
        device = getattr(bus, "serialPortOrig", None)  # slcan leaves its device open when it cannot say goodbye
        if device is not None:
            device.close()
    bus._is_shutdown = True  # else its destructor tries once more, and complains


def one_line(error: Exception) -> str:
    """Why, out of python-can's wrapping of what the system said."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno:
            return os.strerror(cause.errno)
        cause = cause.__cause__ or cause.__context__
    text = str(error).splitlines()
    return text[0] if text else type(error).__name__
