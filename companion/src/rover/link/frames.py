"""What a session needs of a wire: (identifier, payload) pairs in both directions, each with its time.

A CAN bus carries such pairs as they are. A serial line carries them framed: COBS, sequence byte, CRC-16.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from rover_protocol import framing

from rover.link.transport import Transport

# Seconds from the beginning of a simulated millisecond until its bytes are on the firmware's line.
RIG_ADAPTER_S = 0.000806


@dataclass(frozen=True)
class Frame:
    """One good frame, and the companion time at which its last byte came."""

    time: float
    identifier: int
    payload: bytes


@dataclass(frozen=True)
class Counters:
    """Good frames received, and what was wrong with the others."""

    frames: int = 0
    checksum_errors: int = 0
    malformed: int = 0
    lost: int = 0


class FrameTransport(ABC):
    """A wire that carries frames. `send` and `receive` raise `LinkLost` when the wire is gone."""

    port: str
    time_step: float
    """Seconds to which the times of frames, and the firmware's own at the other end, are rounded."""
    lead: float
    """Seconds from a write until its bytes leave; 0 on a real port."""
    last_heard: float | None
    """Companion time of the last byte received; None before the first."""

    @property
    @abstractmethod
    def bytes_written(self) -> int:
        """Bytes given to the port so far."""

    @property
    @abstractmethod
    def bytes_read(self) -> int:
        """Bytes taken from the port so far."""

    @property
    @abstractmethod
    def counters(self) -> Counters:
        """Of what has been received so far."""

    @abstractmethod
    def wire_bytes(self, payload: int) -> float:
        """Length on the wire, in bytes, of a frame with so many bytes of payload."""

    @abstractmethod
    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """Seconds that an undelayed request takes to the other end and its reply takes back, by payload lengths."""

    @abstractmethod
    def send(self, identifier: int, payload: bytes) -> None:
        """Sends one frame."""

    @abstractmethod
    def receive(self) -> list[Frame]:
        """Good frames since the last call, oldest first; never waits for more."""

    @abstractmethod
    def close(self) -> None:
        """Lets the port go. May be called twice."""


class SerialFrames(FrameTransport):
    """Frames over a transport of bytes: numbers what is sent, checks what comes, counts both."""

    def __init__(self, transport: Transport, sequence: int = 0) -> None:
        """`sequence`: of the first frame that is sent."""
        self.bytes = transport
        self.port = transport.port
        self.time_step = transport.time_step
        self.lead = transport.lead
        self.last_heard = None
        self._decoder = framing.Decoder()
        self.sequence = sequence

    @property
    def bytes_written(self) -> int:
        """See FrameTransport."""
        return self.bytes.bytes_written

    @property
    def bytes_read(self) -> int:
        """See FrameTransport."""
        return self.bytes.bytes_read

    @property
    def counters(self) -> Counters:
        """`lost` counts gaps in the sequence byte."""
        decoder = self._decoder
        return Counters(decoder.frames, decoder.checksum_errors, decoder.malformed, decoder.lost)

    def wire_bytes(self, payload: int) -> float:
        """Payload, identifier, sequence, CRC, the first COBS code and the closing zero."""
        return payload + framing.OVERHEAD + framing.DELIMITERS

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """By the baud rate. The adapter of a rig that runs in steps hands a request on `RIG_ADAPTER_S` after the step's
        beginning, and a reply at the end of the step in which it leaves."""
        up, down = (self.wire_bytes(length) * self.bytes.byte_time for length in (request, reply))
        step = self.time_step
        return (RIG_ADAPTER_S + up, math.ceil(down / step) * step) if step else (up, down)

    def send(self, identifier: int, payload: bytes) -> None:
        """See FrameTransport."""
        frame = framing.encode(identifier, self.sequence, payload)
        self.sequence = (self.sequence + 1) & 0xFF
        self.bytes.write(frame)

    def receive(self) -> list[Frame]:
        """See FrameTransport."""
        received: list[Frame] = []
        for time, data in self.bytes.read():
            self.last_heard = time
            for identifier, _, payload in self._decoder.feed(data):
                received.append(Frame(time, identifier, payload))
        return received

    def close(self) -> None:
        """See FrameTransport."""
        self.bytes.close()


def as_frames(transport: Transport | FrameTransport) -> FrameTransport:
    """A transport of bytes gets the serial framing; one of frames is taken as it is."""
    return transport if isinstance(transport, FrameTransport) else SerialFrames(transport)
