"""Speaks the rover's protocol over a serial port with nothing of the companion in between."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import serial
from rover.link.baud import DEFAULT_BAUD
from rover_protocol import framing, messages

from rover_hil.named_values import named_values
from rover_hil.testing.rigs import Client

SESSION = 77
# Seconds to wait for bytes that have been announced.
READ_TIMEOUT_S = 2.0

# Duration in µs and jerk of travel in µm/s³: up to 0.25 m/s within a second, then on.
SEGMENTS = ((500_000, 1_000_000), (500_000, -1_000_000), (8_000_000, 0))

START_DELAY_US = 100_000
# From power-on until a board listens, with a margin.
BOOT_US = 100_000


class FirmwareTalk:
    """An open port with a decoder: everything received stays, by the name of its message."""

    def __init__(self, port: str) -> None:
        self._serial = serial.Serial(port, DEFAULT_BAUD, timeout=READ_TIMEOUT_S)
        self.decoder = framing.Decoder()
        self.bytes_read = 0
        self._written = 0
        self._sequence = 0
        self._keep_alive = 0
        self._received: dict[str, list[dict[str, Any]]] = {}

    def __enter__(self) -> FirmwareTalk:
        return self

    def __exit__(self, *_: object) -> None:
        self._serial.close()

    def write_raw(self, data: bytes) -> int:
        """Writes bytes as they are; returns how many have been written in all."""
        self._serial.write(data)
        self._written += len(data)
        return self._written

    def send(self, name: str, **values: int) -> int:
        """Sends a message of raw values; returns how many bytes have been written in all."""
        message = messages.BY_NAME[name]
        wire = framing.encode(message.ID, self._sequence, message.pack(**values))
        self._sequence = (self._sequence + 1) & 255
        return self.write_raw(wire)

    def hello(self) -> int:
        """Sends the handshake."""
        return self.send("Hello", schema_hash=messages.SCHEMA_HASH, session=SESSION)

    def keep_alive(self) -> int:
        """Feeds the dead-man."""
        self._keep_alive = (self._keep_alive + 1) & 255
        return self.send("KeepAlive", counter=self._keep_alive)

    def arm_and_drive_ahead(self, client: Client) -> int:
        """Handshake, arm, then a straight run of nine seconds; returns the time, µs, at which it has been sent."""
        now = 300_000
        # What is sent to a board that is still starting is lost.
        client.ask(op="advance", to_us=BOOT_US, host_bytes=0)
        client.ask(op="advance", to_us=now, host_bytes=self.hello())
        self.send("Arm", token=1, session=SESSION)
        start = now + START_DELAY_US
        self.send("SegmentStart", index=0, start_time=start)
        for index, (duration_us, jerk) in enumerate(SEGMENTS):
            self.send("SegmentTravel", index=index, duration=duration_us, jerk_travel=jerk)
            self.send("SegmentHeading", index=index, jerk_heading=0, flags=1 if index == 0 else 0)
        now += 20_000
        reply, _ = client.ask(op="advance", to_us=now, host_bytes=self.keep_alive())
        self.read_exactly(reply["marks"][-1][1] - self.bytes_read)
        return now

    def read_exactly(self, count: int) -> bytes:
        """Reads and decodes `count` bytes. Raises TimeoutError when they do not come."""
        data = self._serial.read(count)
        self._take(data)
        if len(data) < count:
            raise TimeoutError(f"{len(data)} of {count} bytes came")
        return bytes(data)

    def wait_for(self, name: str, wanted: Callable[[dict[str, Any]], bool], seconds: float) -> dict[str, Any]:
        """Reads in real time until such a message comes. Raises TimeoutError."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            known = len(self.received(name))
            self._take(self._serial.read(max(1, self._serial.in_waiting)))
            for values in self.received(name)[known:]:
                if wanted(values):
                    return values
        raise TimeoutError(f"no such {name} within {seconds} s; the last was {self.received(name)[-1:]}")

    def received(self, name: str) -> list[dict[str, Any]]:
        """All messages of that name so far, oldest first: raw values, named where the protocol has names."""
        return self._received.get(name, [])

    def newest(self, name: str) -> dict[str, Any]:
        """The last message of that name."""
        return self.received(name)[-1]

    def _take(self, data: bytes) -> None:
        self.bytes_read += len(data)
        for identifier, _, payload in self.decoder.feed(data):
            message, values = messages.decode(identifier, payload)
            self._received.setdefault(message.name, []).append(named_values(message, values))
