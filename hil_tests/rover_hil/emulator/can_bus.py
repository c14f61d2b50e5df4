"""A CAN bus in virtual time (ISO 11898-1): arbitration, the length of frames in bits, acknowledgement, error frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

CLOCK_HZ = 125_000_000
CRC_POLYNOMIAL = 0x4599
# CRC delimiter, acknowledge with its delimiter, end of frame, and the three bits until the next may begin.
TAIL_BITS = 1 + 2 + 7 + 3
ERROR_FRAME_BITS = 6 + 8 + 3
RATE_TOLERANCE = 0.01


@dataclass(frozen=True)
class Frame:
    """A classic frame; a remote one has a length and no data."""

    identifier: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False
    length: int = -1

    def __post_init__(self) -> None:
        if self.length < 0:
            object.__setattr__(self, "length", len(self.data))

    @property
    def arbitration(self) -> tuple[int, ...]:
        """Bits that decide who goes on: 0 wins. A data frame before its remote one, a standard before an extended."""
        if not self.extended:
            return (self.identifier, self.remote, 0, 0, 0)
        return (self.identifier >> 18, 1, 1, self.identifier & 0x3FFFF, self.remote)

    def bits(self) -> int:
        """Bits on the wire with stuff bits and the pause after the frame."""
        head = _number(0, 1)
        if self.extended:
            head += [*_number(self.identifier >> 18, 11), 1, 1, *_number(self.identifier & 0x3FFFF, 18)]
            head += [int(self.remote), 0, 0]
        else:
            head += [*_number(self.identifier, 11), int(self.remote), 0, 0]
        head += _number(min(8, self.length), 4)
        for byte in () if self.remote else self.data:
            head += _number(byte, 8)
        head += _number(_crc(head), 15)
        return len(head) + _stuff_bits(head) + TAIL_BITS


def _number(value: int, width: int) -> list[int]:
    return [value >> bit & 1 for bit in range(width - 1, -1, -1)]


def _crc(bits: list[int]) -> int:
    crc = 0
    for bit in bits:
        crc = (crc << 1 ^ (CRC_POLYNOMIAL if crc >> 14 & 1 ^ bit else 0)) & 0x7FFF
    return crc


def _stuff_bits(bits: list[int]) -> int:
    count, run, last = 0, 0, -1
    for bit in bits:
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            # The stuff bit is the opposite one and begins a run of its own.
            count, run, last = count + 1, 1, 1 - bit
    return count


class Node(Protocol):
    """One controller on the bus."""

    @property
    def bit_rate(self) -> float:
        """Bits per second; 0 while it takes no part."""
        ...

    @property
    def acknowledges(self) -> bool:
        """Whether it drives the bus, and not only listens."""
        ...

    def offered(self) -> Frame | None:
        """What it wants to send now."""
        ...

    def sent(self, frame: Frame) -> None:
        """Its frame has been acknowledged."""

    def heard(self, frame: Frame) -> None:
        """A frame of another node has passed without an error."""

    def failed(self, transmitting: bool, acknowledged: bool) -> None:
        """An error frame has destroyed what was on the bus."""


class CanBus:
    """Any number of nodes. `clock`: rover_plant's."""

    def __init__(self, clock: Any, bit_rate: float = 500_000) -> None:
        self._clock = clock
        self._bit_cycles = CLOCK_HZ / bit_rate
        self._bit_rate = bit_rate
        self._nodes: list[Node] = []
        self._passing: tuple[Node, Frame] | None = None
        self._end = clock.create_alarm(self._ended)
        self._corrupt = 0
        self.broken = False
        """A cable that is cut or shorted: nothing gets through."""

    def join(self, node: Node) -> None:
        """One more node."""
        self._nodes.append(node)

    def corrupt(self, frames: int) -> None:
        """Bit errors in that many of the next frames."""
        self._corrupt += frames

    def request(self) -> None:
        """A node has something to send: it begins now, or when the bus is free."""
        if self._passing is None:
            self._begin()

    def _begin(self) -> None:
        offers = [(node, frame) for node in self._nodes if node.bit_rate and (frame := node.offered())]
        if not offers:
            return
        self._passing = min(offers, key=lambda offer: offer[1].arbitration)
        self._schedule(self._passing[1].bits())

    def _schedule(self, bits: int) -> None:
        self._end.schedule_at(self._clock.cycles + round(bits * self._bit_cycles))

    def _ended(self) -> None:
        assert self._passing is not None
        sender, frame = self._passing
        self._passing = None
        others = [node for node in self._nodes if node is not sender and node.bit_rate]
        acknowledged = any(node.acknowledges for node in others) and not self.broken
        speeds = [sender, *(node for node in others if node.acknowledges)]
        alike = all(abs(node.bit_rate / self._bit_rate - 1) <= RATE_TOLERANCE for node in speeds)
        if self._corrupt:
            self._corrupt -= 1
            alike = False
        if alike and acknowledged:
            sender.sent(frame)
            for node in others:
                node.heard(frame)
        else:
            sender.failed(True, acknowledged)
            for node in others if not self.broken else ():
                node.failed(False, acknowledged)
        self._begin()
