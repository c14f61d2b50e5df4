"""A bad wire on purpose, in both directions: wrong bits, lost, doubled, late and overtaken frames, jitter.

The disturbed transports stand between the session and the real port, so the codecs at both ends meet what a bad wire
would give them. Everything random comes from one seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rover.link.frames import Frame, FrameTransport, SerialFrames
from rover.link.port import CAN_FRAME_BITS
from rover.link.transport import Chunk, Transport
from rover.link.wire_around import BytesAround, WireAround

# Frames that pass one that is reordered.
OVERTAKEN_BY = 3


@dataclass(frozen=True)
class Disturbance:
    """Probabilities per bit and per frame; `delay` frames come up to `delay_time` seconds late; `jitter` in seconds."""

    bit_error_rate: float = 0.0
    drop: float = 0.0
    duplicate: float = 0.0
    delay: float = 0.0
    delay_time: float = 0.05
    reorder: float = 0.0
    jitter: float = 0.0


class NoisyBytes(BytesAround):
    """A transport of bytes some of whose bits are wrong."""

    def __init__(self, inner: Transport, bit_error_rate: float, rng: np.random.Generator) -> None:
        super().__init__(inner)
        self.flipped = 0
        """Bits that were turned over so far, both ways."""
        self._rate = bit_error_rate
        self._rng = rng

    def write(self, data: bytes) -> None:
        """Sends `data` with its share of wrong bits."""
        self.inner.write(self._spoil(data))

    def read(self) -> list[Chunk]:
        """What has come, with its share of wrong bits."""
        return [(time, self._spoil(data)) for time, data in self.inner.read()]

    def _spoil(self, data: bytes) -> bytes:
        count = int(self._rng.binomial(8 * len(data), self._rate))
        if count == 0:
            return data
        self.flipped += count
        spoiled = bytearray(data)
        for position in self._rng.choice(8 * len(data), size=count, replace=False).tolist():
            spoiled[position // 8] ^= 1 << position % 8
        return bytes(spoiled)


@dataclass(eq=False)
class _Waiting:
    """A frame on its way: when it may go on, and after which frame of its direction, by number."""

    due: float
    number: int
    behind: int
    identifier: int
    payload: bytes


class _Direction:
    """Frames on their way one way."""

    def __init__(self) -> None:
        self._waiting: list[_Waiting] = []
        self._number = 0

    def add(self, due: float, overtaken: bool, identifier: int, payload: bytes) -> None:
        """Takes a frame; one that is overtaken goes on right behind the third that comes after it."""
        self._number += 1
        for each in self._waiting:
            if each.behind == self._number:
                each.due = max(each.due, due)
        behind = self._number + OVERTAKEN_BY if overtaken else self._number
        self._waiting.append(_Waiting(due, self._number, behind, identifier, payload))

    def take(self, now: float) -> list[_Waiting]:
        """What is due, in the order in which it goes on."""
        ready = [each for each in self._waiting if each.due <= now + 1e-9 and each.behind <= self._number]
        self._waiting = [each for each in self._waiting if each not in ready]
        return sorted(ready, key=lambda each: (each.due, each.behind, -each.number))


class DisturbedFrames(WireAround):
    """A transport of frames that loses, doubles, delays and reorders them, and makes their times unsteady.

    The jitter of a frame that is sent lies before the moment at which it reaches the wire: the sender's stamp, which
    is the present and `lead`, is earlier by it. That of a frame that is received lies after its arrival.
    """

    def __init__(
        self, inner: FrameTransport, disturbance: Disturbance, now: Callable[[], float], rng: np.random.Generator
    ) -> None:
        super().__init__(inner)
        self.last_heard = None
        self.lead = inner.lead
        self.dropped = 0
        """Frames that were thrown away so far, both ways."""
        self._disturbance = disturbance
        self._now = now
        self._rng = rng
        self._out, self._in = _Direction(), _Direction()

    def send(self, identifier: int, payload: bytes) -> None:
        """Sends one frame, perhaps."""
        self.lead = self.inner.lead - self._jitter()
        self._admit(self._out, self._now(), identifier, payload)
        self._send_due()

    def receive(self) -> list[Frame]:
        """Frames that have come through by now, oldest first."""
        self._send_due()
        for frame in self.inner.receive():
            self._admit(self._in, frame.time + self._jitter(), frame.identifier, frame.payload)
        frames = [Frame(each.due, each.identifier, each.payload) for each in self._in.take(self._now())]
        if frames:
            self.last_heard = frames[-1].time
        return frames

    def _send_due(self) -> None:
        for each in self._out.take(self._now()):
            self.inner.send(each.identifier, each.payload)

    def _admit(self, direction: _Direction, at: float, identifier: int, payload: bytes) -> None:
        chance, rng = self._disturbance, self._rng
        # A CAN controller throws a frame with a wrong bit away; on a serial line the bytes themselves are spoiled.
        bits = CAN_FRAME_BITS + 8 * len(payload)
        lost = 1.0 - (1.0 - chance.drop) * math.exp(bits * math.log1p(-chance.bit_error_rate))
        if rng.random() < lost:
            self.dropped += 1
            return
        for _ in range(1 + int(rng.random() < chance.duplicate)):
            late = chance.delay_time * rng.random() if rng.random() < chance.delay else 0.0
            direction.add(at + late, bool(rng.random() < chance.reorder), identifier, payload)

    def _jitter(self) -> float:
        return self._disturbance.jitter * self._rng.random()


def disturb(
    transport: FrameTransport, disturbance: Disturbance, now: Callable[[], float], seed: int
) -> DisturbedFrames:
    """The same port with a bad wire; `now` is the session's clock."""
    rng = np.random.default_rng(seed)
    if isinstance(transport, SerialFrames):
        transport = SerialFrames(NoisyBytes(transport.bytes, disturbance.bit_error_rate, rng))
        disturbance = replace(disturbance, bit_error_rate=0.0)
    return DisturbedFrames(transport, disturbance, now, rng)
