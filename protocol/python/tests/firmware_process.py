"""The real firmware in virtual time for the tests of this folder: rover-sitl, one end of its line, two wheels."""

from __future__ import annotations

import os
import select
import socket
import struct
import subprocess
from pathlib import Path

import golden
import pytest
from rover_protocol import framing, messages

BINARY = Path(os.environ.get("ROVER_SITL", golden.PROTOCOL.parent / "target" / "release" / "rover-sitl"))
REQUEST, REPLY = struct.Struct("<QiiIHBBQ8x"), struct.Struct("<hhBB2xQ")
NO_SENSOR = 255
TIMEOUT_US = 25_000
"""Until the driver of a sonar that hears nothing says so."""
COUNTS_PER_MS = 3.4
"""Of a wheel at full duty."""


class Firmware:
    """A running rover-sitl whose wheels do as they are told. Time goes on only in `tick`."""

    def __init__(self, wire: str = "serial", descriptor: int | None = None) -> None:
        """Opens a socket pair as its line, or hands `descriptor` over: then it takes what is there, uncounted."""
        if not BINARY.exists():
            pytest.skip(f"{BINARY.name} is not built: run 'make setup'")
        self.line, far_end = socket.socketpair() if descriptor is None else (None, None)
        number = far_end.fileno() if far_end else descriptor
        self._process = subprocess.Popen(
            [BINARY, "--serial-fd", str(number), "--wire", wire],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(number,),
        )
        if far_end:
            far_end.close()
        self.now_us = 0
        self.powered = False
        self.duties = (0, 0)
        self._wheels = [0.0, 0.0]
        self._given = 0
        self._taken = 0
        self._ping: tuple[int, int] | None = None

    def send(self, data: bytes) -> None:
        """Bytes that the firmware's end has received by the next tick."""
        self.line.sendall(data)
        self._given += len(data)

    def tick(self) -> bytes:
        """One millisecond; what came out on the line."""
        self.now_us += 1000
        for side, duty in enumerate(self.duties):
            self._wheels[side] += duty / 32768 * COUNTS_PER_MS
        left, right = (int(way) for way in self._wheels)
        due = self._given if self.line else 2**64 - 1
        sensor = NO_SENSOR
        if self._ping and self._ping[1] <= self.now_us:
            (sensor, _), self._ping = self._ping, None
        self._process.stdin.write(REQUEST.pack(self.now_us, left, right, 0, 7400, sensor, 0, due))
        self._process.stdin.flush()
        left, right, flags, pinged, sent = REPLY.unpack(self._process.stdout.read(REPLY.size))
        self.duties, self.powered = (left, right), bool(flags & 1)
        if pinged != NO_SENSOR:
            self._ping = (pinged, self.now_us + TIMEOUT_US)
        fresh, self._taken = sent - self._taken, sent
        return self._read(fresh) if self.line else b""

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count and select.select([self.line], [], [], 2.0)[0]:
            data += self.line.recv(count - len(data))
        return data

    def close(self) -> None:
        self._process.stdin.close()
        self._process.wait(timeout=2)
        self._process.stdout.close()
        if self.line:
            self.line.close()


class SerialText:
    """(identifier, payload) pairs as framed bytes."""

    opening = b""

    def __init__(self) -> None:
        self._sequence = 0
        self._decoder = framing.Decoder()

    def encode(self, identifier: int, payload: bytes) -> bytes:
        self._sequence = (self._sequence + 1) & 255
        return framing.encode(identifier, self._sequence, payload)

    def decode(self, data: bytes) -> list[tuple[int, bytes]]:
        return [(identifier, payload) for identifier, _, payload in self._decoder.feed(data)]


class CanText:
    """The same as lines of slcan."""

    opening = b"C\rS6\rO\r"

    def __init__(self) -> None:
        self._rest = b""

    @staticmethod
    def encode(identifier: int, payload: bytes) -> bytes:
        return b"t%03X%d%s\r" % (identifier, len(payload), payload.hex().encode())

    def decode(self, data: bytes) -> list[tuple[int, bytes]]:
        *lines, self._rest = (self._rest + data).split(b"\r")
        frames = [line.lstrip(b"\a") for line in lines]
        return [(int(f[1:4], 16), bytes.fromhex(f[5:].decode())) for f in frames if f[:1] == b"t"]


class Conversation:
    """A companion without manners of its own on either wire: sends what it is told and keeps what it hears."""

    def __init__(self, wire: str) -> None:
        self.firmware = Firmware(wire)
        self.text = CanText() if wire == "can" else SerialText()
        self.firmware.send(self.text.opening)
        self.heard: list[tuple[str, dict[str, int]]] = []
        self.last: dict[str, dict[str, int]] = {}

    def send(self, message: object, /, **fields: int) -> None:
        self.firmware.send(self.text.encode(message.ID, message.pack(**fields)))

    def run(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self.hear(self.text.decode(self.firmware.tick()))

    def hear(self, frames: list[tuple[int, bytes]]) -> None:
        for identifier, payload in frames:
            message, values = messages.decode(identifier, payload)
            self.heard.append((message.name, values))
            self.last[message.name] = values

    def arm(self, token: int = 1) -> None:
        """Through boot and handshake to Armed."""
        self.run(20)
        self.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=1)
        self.run(5)
        self.send(messages.Arm, token=token)
        self.send(messages.KeepAlive, counter=self.firmware.now_us // 1000 & 255)
        self.run(5)
        assert self.last["State"]["state"] == messages.STATE_ARMED, self.last["State"]

    def close(self) -> None:
        self.firmware.close()
