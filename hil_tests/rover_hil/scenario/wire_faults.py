"""What a bad wire does to frames and bytes. Pure but for its random generator: the same seed gives the same losses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from rover_protocol import framing, messages

from rover_hil.scenario.language import Injection

Packet = tuple[int, bytes]
"""Identifier and payload."""

TO_FIRMWARE = "to-firmware"
FROM_FIRMWARE = "from-firmware"
FLIP = 0x5A5A5A5A


class WireFaults:
    """The wire's faults of this moment, by the name of their injection."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng([seed, 0x57495245])
        self._active: dict[str, Injection] = {}
        self._held: Packet | None = None
        self._noise_owed = {TO_FIRMWARE: 0.0, FROM_FIRMWARE: 0.0}
        self._stuck: int | None = None

    def begin(self, injection: Injection) -> None:
        """Puts a fault in."""
        self._active[injection.name] = injection

    def end(self, injection: Injection) -> None:
        """Takes it out."""
        self._active.pop(injection.name, None)

    def frames(self, packet: Packet, direction: str) -> list[Packet]:
        """What becomes of a frame: nothing, itself, itself twice, or itself with the one that was held back."""
        if self._cut(direction) or self._lost(packet, direction):
            return []
        packet = self._rewritten(packet, direction)
        if direction != TO_FIRMWARE:
            return [packet]
        packets = [packet] * (2 if self._concerned("frame-duplicate", packet) else 1)
        if self._concerned("frame-reorder", packet) and self._held is None:
            self._held = packet
            return packets[1:]
        if self._held is not None:
            packets.append(self._held)
            self._held = None
        return packets

    def delay(self, packet: Packet) -> float:
        """Seconds by which a frame to the firmware comes late."""
        late = self._concerned("frame-delay", packet)
        return max((fault.number("delay_s") for fault in late), default=0.0)

    def spoil(self, data: bytes, direction: str) -> bytes:
        """Bytes as they arrive: some lost, some with flipped bits."""
        spoiled = np.frombuffer(data, dtype=np.uint8)
        for fault in self._of("byte-loss", direction):
            spoiled = spoiled[self._random.random(len(spoiled)) >= fault.number("rate")]
        for fault in self._of("bit-errors", direction):
            bits = np.unpackbits(spoiled)
            bits ^= (self._random.random(len(bits)) < fault.number("rate")).astype(np.uint8)
            spoiled = np.packbits(bits)
        return spoiled.tobytes()

    def noise(self, elapsed: float, direction: str) -> bytes:
        """Random bytes that came out of nothing in the last `elapsed` seconds."""
        sources = self._of("noise", direction)
        if not sources:
            return b""
        self._noise_owed[direction] += elapsed * sum(f.number("bytes_per_second") for f in sources)
        count = int(self._noise_owed[direction])
        self._noise_owed[direction] -= count
        return self._random.bytes(count)

    def _cut(self, direction: str) -> bool:
        return bool(self._of("serial-cut", direction)) or any(f.fault == "can-bus-off" for f in self._active.values())

    def _lost(self, packet: Packet, direction: str) -> bool:
        candidates = [fault for fault in self._of("frame-loss", direction) if _names(fault, packet)]
        return any(self._random.random() < fault.number("rate") for fault in candidates)

    def _rewritten(self, packet: Packet, direction: str) -> Packet:
        identifier, payload = packet
        message = messages.BY_ID.get(identifier)
        if message is None:
            return packet
        side = {TO_FIRMWARE: ("Hello", "companion"), FROM_FIRMWARE: ("HelloReply", "firmware")}[direction]
        wrong = [f for f in self._active.values() if f.fault == "wrong-schema" and f.parameters["side"] == side[1]]
        if message.name == side[0] and wrong:
            raw = dict(messages.decode(identifier, payload)[1])
            return identifier, message.pack(**{**raw, "schema_hash": int(raw["schema_hash"]) ^ FLIP})
        if message.name == "KeepAlive" and direction == TO_FIRMWARE:
            stuck = any(f.fault == "keep-alive-stuck" for f in self._active.values())
            counter = self._stuck if stuck and self._stuck is not None else payload[0]
            self._stuck = counter
            return identifier, bytes([counter])
        return packet

    def _of(self, fault: str, direction: str) -> list[Injection]:
        ways = ("both", direction)
        return [f for f in self._active.values() if f.fault == fault and f.parameters["direction"] in ways]

    def _concerned(self, fault: str, packet: Packet) -> list[Injection]:
        return [f for f in self._active.values() if f.fault == fault and _names(f, packet)]


def _names(fault: Injection, packet: Packet) -> bool:
    """Whether the fault concerns frames of this kind."""
    wanted = fault.parameters.get("messages", ())
    assert isinstance(wanted, tuple)
    message = messages.BY_ID.get(packet[0])
    return not wanted or (message is not None and message.name in wanted)


def packets_of(wire: bytes) -> list[tuple[int, int, bytes]]:
    """(identifier, sequence, payload) of whole good frames."""
    return list(framing.Decoder().feed(wire))


def split_frames(buffer: bytearray, data: Iterable[int] | bytes) -> Sequence[bytes]:
    """Adds `data` to `buffer` and takes the whole frames out of it, each with its closing zero."""
    buffer += bytes(data)
    frames: list[bytes] = []
    while (end := buffer.find(0)) >= 0:
        frames.append(bytes(buffer[: end + 1]))
        del buffer[: end + 1]
    return frames
