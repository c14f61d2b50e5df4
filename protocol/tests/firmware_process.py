"""The real firmware in virtual time for the tests of this folder: rover-sitl, one end of its line, two wheels."""

from __future__ import annotations

import os
import select
import socket
import subprocess
from pathlib import Path
from typing import cast

import pytest
from rover_protocol import framing, messages
from rover_protocol.message import Message
from rover_protocol.rig_tick import ALL_HOST_BYTES, NO_SENSOR, POWERED, TickReply, TickRequest

from protocol.tests import golden

BINARY = Path(os.environ.get("ROVER_SITL", golden.PROTOCOL.parent / "target" / "release" / "rover-sitl"))
BATTERY_MV = 7400
# Until the driver of a sonar that hears nothing says so.
TIMEOUT_US = 25_000
# Of a wheel at full duty.
COUNTS_PER_MS = 3.4


class Firmware:
    """A running rover-sitl whose wheels do as they are told. Time goes on only in `tick`."""

    def __init__(self, wire: str = "serial", descriptor: int | None = None) -> None:
        """Opens a socket pair as its line, or hands `descriptor` over: then it takes what is there, uncounted."""
        if not BINARY.exists():
            pytest.skip(f"{BINARY.name} is not built: run 'make setup'")
        self.line: socket.socket | None = None
        far_end: socket.socket | None = None
        if descriptor is None:
            self.line, far_end = socket.socketpair()
            number = far_end.fileno()
        else:
            number = descriptor
        self._process = subprocess.Popen(
            [BINARY, "--serial-fd", str(number), "--wire", wire],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(number,),
        )
        if far_end:
            far_end.close()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._replies = self._process.stdin, self._process.stdout
        self.now_us = 0
        self.powered = False
        self.duties = (0, 0)
        self._wheels = [0.0, 0.0]
        self._given = 0
        self._taken = 0
        self._ping: tuple[int, int] | None = None

    def send(self, data: bytes) -> None:
        """Bytes that the firmware's end has received by the next tick."""
        assert self.line is not None, "a descriptor that was handed over is written by its owner"
        self.line.sendall(data)
        self._given += len(data)

    def tick(self) -> bytes:
        """One millisecond; what came out on the line."""
        self.now_us += 1000
        for side, duty in enumerate(self.duties):
            self._wheels[side] += duty / 32768 * COUNTS_PER_MS
        left, right = (int(way) for way in self._wheels)
        due = self._given if self.line else ALL_HOST_BYTES
        sensor = NO_SENSOR
        if self._ping and self._ping[1] <= self.now_us:
            (sensor, _), self._ping = self._ping, None
        request = TickRequest(
            now_us=self.now_us,
            encoder_left=left,
            encoder_right=right,
            battery_mv=BATTERY_MV,
            echo_sensor=sensor,
            host_bytes_due=due,
        )
        self._requests.write(request.pack())
        self._requests.flush()
        reply = TickReply.unpack(self._replies.read(TickReply.SIZE))
        self.duties, self.powered = (reply.duty_left, reply.duty_right), bool(reply.flags & POWERED)
        if reply.sonar_trigger != NO_SENSOR:
            self._ping = (reply.sonar_trigger, self.now_us + TIMEOUT_US)
        fresh, self._taken = reply.bytes_sent - self._taken, reply.bytes_sent
        return _read(self.line, fresh) if self.line else b""

    def close(self) -> None:
        self._requests.close()
        self._process.wait(timeout=2)
        self._replies.close()
        if self.line:
            self.line.close()


def _read(line: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count and select.select([line], [], [], 2.0)[0]:
        data += line.recv(count - len(data))
    return data


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

    def send(self, message: Message, /, **fields: int) -> None:
        self.firmware.send(self.text.encode(message.ID, message.pack(**fields)))

    def run(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self.hear(self.text.decode(self.firmware.tick()))

    def hear(self, frames: list[tuple[int, bytes]]) -> None:
        for identifier, payload in frames:
            message, raw = messages.decode(identifier, payload)
            values = cast(dict[str, int], raw)
            self.heard.append((message.name, values))
            self.last[message.name] = values

    def arm(self, token: int = 1) -> None:
        """Through boot and handshake to Armed."""
        self.run(20)
        self.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=1)
        self.run(5)
        self.send(messages.Arm, token=token, session=1)
        self.send(messages.KeepAlive, counter=0)
        self.run(5)
        assert self.last["State"]["state"] == messages.STATE_ARMED, self.last["State"]

    def close(self) -> None:
        self.firmware.close()
