"""Messages over a wire: packs what is sent, unpacks what comes, and shows all of it to a tap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rover_protocol import messages

from rover.link.frames import Counters, FrameTransport, as_frames
from rover.link.transport import Transport

Tap = Callable[[str, float, int, bytes], None]
"""Called with "rx" or "tx", companion time, identifier and payload of every frame."""


@dataclass(frozen=True)
class Received:
    """One good frame: raw integer fields, and the companion time at which its last byte came."""

    time: float
    name: str
    fields: dict[str, int | bytes]


class Wire:
    """Sends and receives messages by name. Raises `LinkLost` through the transport."""

    def __init__(self, transport: Transport | FrameTransport, tap: Tap | None = None) -> None:
        self.transport = as_frames(transport)
        self.frames_sent = 0
        self.unknown = 0
        self._tap = tap

    @property
    def counters(self) -> Counters:
        """Of what has been received so far."""
        return self.transport.counters

    @property
    def last_heard(self) -> float | None:
        """Companion time of the last byte received; None before the first."""
        return self.transport.last_heard

    def send(self, name: str, time: float, **raw: int) -> None:
        """Puts one message on the wire."""
        message = messages.BY_NAME[name]
        payload = message.pack(**raw)
        self.transport.send(message.ID, payload)
        self.frames_sent += 1
        if self._tap is not None:
            self._tap("tx", time, message.ID, payload)

    def receive(self) -> list[Received]:
        """Good frames since the last call; frames that this version does not know are counted and skipped."""
        received: list[Received] = []
        for frame in self.transport.receive():
            if self._tap is not None:
                self._tap("rx", frame.time, frame.identifier, frame.payload)
            try:
                message, fields = messages.decode(frame.identifier, frame.payload)
            except ValueError:
                self.unknown += 1
                continue
            received.append(Received(frame.time, message.name, fields))
        return received
