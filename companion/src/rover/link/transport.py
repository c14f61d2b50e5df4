"""Bytes to and from the firmware over a serial port, each chunk with the time at which it came.

A thread reads the port through pyserial and stamps what comes. A lock-stepped rig has a transport of its own, which
knows at which virtual time each byte was sent (`rover_hil.client.line`).
"""

from __future__ import annotations

import os
import threading
from collections import deque
from typing import Protocol

import serial

from rover.errors import LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.link.claim import Claim
from rover.link.clock import WallClock

Chunk = tuple[float, bytes]

# Seconds until a port that takes no bytes counts as lost.
WRITE_TIMEOUT_S = 2.0


class Transport(Protocol):
    """What the session needs of a wire. Both methods raise `LinkLost` when the wire is gone."""

    @property
    def port(self) -> str:
        """Its name."""
        ...

    @property
    def bytes_written(self) -> int:
        """In all."""
        ...

    @property
    def bytes_read(self) -> int:
        """In all."""
        ...

    @property
    def byte_time(self) -> float:
        """Seconds that one byte takes on the wire; 0 where it travels at once (USB)."""
        ...

    @property
    def lead(self) -> float:
        """Seconds from a write until its bytes leave; 0 on a real port."""
        ...

    @property
    def time_step(self) -> float:
        """Seconds to which the times of chunks, and the firmware's own at the other end, are rounded."""
        ...

    def write(self, data: bytes) -> None:
        """Sends all of `data`."""
        ...

    def read(self) -> list[Chunk]:
        """What has come since the last call, oldest first; never waits for more."""
        ...

    def close(self) -> None:
        """Lets the port go. May be called twice."""
        ...


def open_port(port: str, baud: int, timeout: float) -> serial.Serial:
    """Opens a serial port, for nobody else besides. Raises `PreflightFailed` when that is not possible."""
    try:
        return serial.Serial(port, baud, timeout=timeout, write_timeout=WRITE_TIMEOUT_S, exclusive=True)
    except (OSError, ValueError) as error:
        raise PreflightFailed(f"cannot open the port {port}: {_reason(error)}") from error


class SerialTransport:
    """A real port: a thread reads it and stamps each chunk with `clock`."""

    time_step = 0.0
    lead = 0.0

    def __init__(self, port: str, baud: int = DEFAULT_BAUD, clock: WallClock | None = None) -> None:
        self.port = port
        self.byte_time = 0.0 if _is_usb(port) else 10.0 / baud
        self.bytes_written = 0
        self.bytes_read = 0
        self._clock = clock or WallClock()
        self._claim = Claim(port)
        try:
            self._serial = open_port(port, baud, timeout=0.05)
        except PreflightFailed:
            self._claim.release()
            raise
        self._chunks: deque[Chunk] = deque()
        self._failure: str | None = None
        self._closing = False
        self._reader = threading.Thread(target=self._read_forever, name="serial-reader", daemon=True)
        self._reader.start()

    def write(self, data: bytes) -> None:
        """Sends all of `data`; raises `LinkLost`."""
        if self._failure is not None:
            raise LinkLost(self._failure)
        write_all(self._serial, self.port, data)
        self.bytes_written += len(data)

    def read(self) -> list[Chunk]:
        """Chunks since the last call; raises `LinkLost` once everything read before the failure is delivered."""
        chunks: list[Chunk] = []
        while self._chunks:
            chunks.append(self._chunks.popleft())
        if not chunks and self._failure is not None:
            raise LinkLost(self._failure)
        self.bytes_read += sum(len(data) for _, data in chunks)
        return chunks

    def close(self) -> None:
        """Ends the reader and closes the port."""
        self._closing = True
        if self._reader is not threading.current_thread():
            self._reader.join(timeout=1.0)
        close_port(self._serial)
        self._claim.release()

    def _read_forever(self) -> None:
        while not self._closing:
            try:
                data = self._serial.read(max(1, self._serial.in_waiting))
            except (OSError, TypeError, ValueError) as error:
                if not self._closing:
                    self._failure = lost(self.port, error)
                return
            if data:
                self._chunks.append((self._clock.now(), data))


def _is_usb(port: str) -> bool:
    """True for a board's own USB port, whose baud rate means nothing."""
    return any(kind in port for kind in ("ttyACM", "usbmodem"))


def write_all(port: serial.Serial, name: str, data: bytes) -> None:
    """Sends all of `data` over the port of that name. Raises LinkLost."""
    try:
        port.write(data)
    except (OSError, TypeError, ValueError) as error:
        raise LinkLost(lost(name, error)) from error


def close_port(port: serial.Serial) -> None:
    """Closes it, whether or not it is still there."""
    try:
        port.close()
    except OSError:
        return  # the other end is gone already: there is nothing left to close


def lost(name: str, error: Exception) -> str:
    """The line that LinkLost carries."""
    return f"link lost: {name}: {_reason(error)}"


def _reason(error: Exception) -> str:
    """One line out of an OSError or pyserial's wrapping of one."""
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)
    text = str(error).splitlines()
    return text[0] if text else type(error).__name__
