"""Frames over a transport: numbers what is sent, checks what comes, counts both, and shows all of it to a tap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rover_protocol import framing, messages

from rover.link.transport import Transport

Tap = Callable[[str, float, int, bytes], None]
"""Called with "rx" or "tx", companion time, identifier and payload of every frame."""


@dataclass(frozen=True)
class Received:
    """One good frame: raw integer fields, and the companion time at which its last byte came."""

    time: float
    name: str
    fields: dict[str, int | bytes]
    wire_bytes: int


class Wire:
    """Sends and receives messages by name. Raises `LinkLost` through the transport."""

    def __init__(self, transport: Transport, tap: Tap | None = None) -> None:
        self.transport = transport
        self.decoder = framing.Decoder()
        self.frames_sent = 0
        self.unknown = 0
        self.last_heard: float | None = None
        """Companion time of the last byte received; None before the first."""
        self._tap = tap
        self._sequence = 0

    def send(self, name: str, time: float, **raw: int) -> int:
        """Puts one message on the wire; returns its length there in bytes."""
        message = messages.BY_NAME[name]
        payload = message.pack(**raw)
        frame = framing.encode(message.ID, self._sequence, payload)
        self._sequence = (self._sequence + 1) & 0xFF
        self.transport.write(frame)
        self.frames_sent += 1
        if self._tap is not None:
            self._tap("tx", time, message.ID, payload)
        return len(frame)

    def receive(self) -> list[Received]:
        """Good frames since the last call; frames that this version does not know are counted and skipped."""
        received: list[Received] = []
        for time, data in self.transport.read():
            self.last_heard = time
            for identifier, _, payload in self.decoder.feed(data):
                if self._tap is not None:
                    self._tap("rx", time, identifier, payload)
                try:
                    message, fields = messages.decode(identifier, payload)
                except ValueError:
                    self.unknown += 1
                    continue
                received.append(Received(time, message.name, fields, len(payload) + framing.OVERHEAD + 2))
        return received
