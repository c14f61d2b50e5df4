"""What comes in from a real rover in one cycle, so that it can be written down and given back.

Time is read once, at the beginning of a cycle; bytes come in where the wire is read; how far time has gone on since is
read when the clock is asked. Nothing else of a device enters what follows, so a replay of these is the mission again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from rover.errors import LinkLost
from rover.link.frames import Frame, FrameTransport, SerialFrames
from rover.link.transport import Chunk, Transport
from rover.link.wire_around import BytesAround, WireAround


@dataclass
class Cycle:
    """One cycle's inputs. Times in seconds of the companion's clock.

    chunks: bytes of a serial line; frames: of a bus. leads: how long after `time` each clock request left.
    sent: frames that were sent in it; failed: what was tried last, "send" or "receive", when the link broke then.
    """

    time: float
    chunks: list[Chunk] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    leads: list[float] = field(default_factory=list)
    sent: int = 0
    failed: str = ""
    why: str = ""


OnCycle = Callable[[Cycle], None]


class Timed(Protocol):
    """The part of a rig that knows the cycle."""

    cycle: Cycle

    def lead(self) -> float:
        """Seconds since the cycle's own time."""
        ...


class TappedBytes(BytesAround):
    """A serial line whose chunks are noted in the cycle. Is a `Transport`."""

    def __init__(self, inner: Transport, timed: Timed) -> None:
        super().__init__(inner)
        self._timed = timed

    def write(self, data: bytes) -> None:
        """See Transport."""
        self.inner.write(data)

    def read(self) -> list[Chunk]:
        """See Transport."""
        chunks = self.inner.read()
        self._timed.cycle.chunks += chunks
        return chunks


class TappedWire(WireAround):
    """A wire whose input is noted in the cycle; what was received before it was made is none of its business."""

    def __init__(self, inner: FrameTransport, timed: Timed) -> None:
        self._serial = isinstance(inner, SerialFrames)
        self._timed = timed
        if isinstance(inner, SerialFrames):  # a new decoder begins where the mission does, as a replay's does
            inner = SerialFrames(TappedBytes(inner.bytes, timed), inner.sequence)
        super().__init__(inner)

    @property
    def lead(self) -> float:  # type: ignore[override]
        """Seconds since the cycle began: what is written leaves now."""
        lead = self._timed.lead()
        self._timed.cycle.leads.append(lead)
        return lead

    @property
    def last_heard(self) -> float | None:  # type: ignore[override]
        """See FrameTransport."""
        return self.inner.last_heard

    def send(self, identifier: int, payload: bytes) -> None:
        """See FrameTransport."""
        try:
            self.inner.send(identifier, payload)
        except LinkLost as error:
            self._timed.cycle.failed, self._timed.cycle.why = "send", str(error)
            raise
        self._timed.cycle.sent += 1

    def receive(self) -> list[Frame]:
        """See FrameTransport."""
        try:
            frames = self.inner.receive()
        except LinkLost as error:
            self._timed.cycle.failed, self._timed.cycle.why = "receive", str(error)
            raise
        if not self._serial:
            self._timed.cycle.frames += frames
        return frames
