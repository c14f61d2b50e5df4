"""A small firmware made of a script: enough of one to answer the companion, in memory or over a pty."""

from __future__ import annotations

import os
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from typing import cast

import pytest
from rover.link.baud import DEFAULT_BAUD
from rover_protocol import framing, messages


class ScriptedFirmware:
    """Takes bytes, returns bytes. Its clock runs `offset_us` ahead of the caller's and `drift` faster."""

    def __init__(self, offset_us: int = 5_000_000, drift: float = 0.0) -> None:
        self.offset_us = offset_us
        self.drift = drift
        self.schema_hash = messages.SCHEMA_HASH
        self.decoder = framing.Decoder()
        self.sequence = 0
        self.next_index = 0
        self.queue: list[tuple[int, int, int, int]] = []
        self.starts: dict[int, int] = {}
        self.half: dict[int, tuple[int, int]] = {}
        self.state = messages.STATE_DISARMED
        self.cause = messages.STATE_CAUSE_NONE
        self.token = 7
        self.handshake = 0
        self.refuse_arming = False
        self.drop: Callable[[str, int], bool] = lambda name, count: False
        self.received: list[str] = []
        self.keep_alives: list[int] = []
        self.counts: dict[str, int] = {}
        self.capacity = 64
        self.mute = False

    def clock_us(self, now: float) -> int:
        return round(now * 1e6 * (1.0 + self.drift)) + self.offset_us

    def frame(self, name: str, **raw: int | bytes) -> bytes:
        message = messages.BY_NAME[name]
        data = framing.encode(message.ID, self.sequence & 255, message.pack(**raw))
        self.sequence += 1
        return data

    def status(self) -> bytes:
        return self.frame(
            "MotionStatus",
            next_index=self.next_index & 0xFFFF,
            free_slots=max(0, self.capacity - len(self.queue)),
            queued=len(self.queue),
            executing=(self.next_index - 1) & 0xFFFF,
        )

    def heartbeat(self) -> bytes:
        flags = self.handshake
        return self.frame("State", state=self.state, cause=self.cause, arm_token=self.token, flags=flags)

    def tick(self, now: float) -> bytes:
        """What it sends by itself every 20 ms."""
        if self.mute:
            return b""
        stamp = self.clock_us(now) // 1000 & 0xFFFF
        return self.frame("WheelTicks", time=stamp, left=int(now * 100), right=-5) + self.status() + self.heartbeat()

    def receive(self, data: bytes, now: float) -> bytes:
        out = b""
        for identifier, _, payload in self.decoder.feed(data):
            message, raw = messages.decode(identifier, payload)
            count = self.counts[message.name] = self.counts.get(message.name, 0) + 1
            self.received.append(message.name)
            if not self.drop(message.name, count):
                out += self.answer(message.name, cast(dict[str, int], raw), now)
        return b"" if self.mute else out

    def answer(self, name: str, raw: dict[str, int], now: float) -> bytes:
        if name == "Hello":
            accepted = raw["schema_hash"] == self.schema_hash
            self.handshake = int(accepted)
            reply = self.frame("HelloReply", schema_hash=self.schema_hash, version_minor=1, board=0)
            return reply + self.frame("HelloBuild", git_hash=0xABCD, accepted=int(accepted), session=raw["session"])
        if name == "ClockRequest":
            at = self.clock_us(now) & 0xFFFF_FFFF
            return self.frame("ClockReply", sequence=raw["sequence"], receive_time=at, turnaround=0)
        if name == "Arm":
            if raw["token"] == self.token:
                return b""
            self.token = raw["token"]
            if self.refuse_arming:
                return self.frame("Fault", code=messages.FAULT_CODE_ARM_REFUSED, active=0, count=1) + self.heartbeat()
            self.state = messages.STATE_ARMED
            return self.heartbeat()
        if name in ("Stop", "EmergencyStop"):
            self.flush(messages.STATE_LATCHED, messages.STATE_CAUSE_STOP_COMMAND)
            return self.heartbeat()
        if name == "Disarm":
            self.flush(messages.STATE_DISARMED, messages.STATE_CAUSE_DISARM)
            return self.heartbeat()
        if name == "KeepAlive":
            self.keep_alives.append(raw["counter"])
        if name == "SegmentStart":
            self.starts[raw["index"]] = raw["start_time"]
        if name == "SegmentTravel":
            self.half[raw["index"]] = (raw["duration"], raw["jerk_travel"])
        if name == "SegmentHeading":
            self.accept(raw, now)
            return self.status()
        if name == "ParameterGet":
            return self.frame("ParameterValue", identifier=raw["identifier"], value=42, status=0)
        return b""

    def accept(self, raw: dict[str, int], now: float) -> None:
        index = raw["index"]
        if self.state != messages.STATE_ARMED or index != self.next_index & 0xFFFF or index not in self.half:
            return
        if len(self.queue) >= self.capacity:
            return
        if raw["flags"] & 1 and self.starts.get(index, 0) <= self.clock_us(now) & 0xFFFF_FFFF:
            return  # its start lies in the past: refused
        duration, jerk = self.half.pop(index)
        self.queue.append((index, duration, jerk, raw["flags"]))
        self.next_index += 1

    def flush(self, state: int, cause: int) -> None:
        self.queue.clear()
        self.state, self.cause = state, cause


class MemoryWorld:
    """Virtual time, a scripted firmware and the wire between them: a transport and a clock in one."""

    port = "the port"
    byte_time = 10.0 / DEFAULT_BAUD
    time_step = 0.0
    lead = 0.0

    def __init__(self, firmware: ScriptedFirmware, delay: float = 0.001) -> None:
        self.firmware = firmware
        self.delay = delay
        self.time = 0.0
        self.bytes_written = 0
        self.bytes_read = 0
        self.outbox = b""
        self.inbox: list[tuple[float, bytes]] = []

    def now(self) -> float:
        return self.time

    def advance(self, to: float) -> None:
        answer = self.firmware.receive(self.outbox, self.time + self.delay)
        self.outbox = b""
        if answer:
            self.inbox.append((self.time + 2.0 * self.delay, answer))
        self.time = to
        said = self.firmware.tick(to)
        if said:
            self.inbox.append((to, said))

    def write(self, data: bytes) -> None:
        self.outbox += data
        self.bytes_written += len(data)

    def read(self) -> list[tuple[float, bytes]]:
        chunks, self.inbox = self.inbox, []
        self.bytes_read += sum(len(data) for _, data in chunks)
        return chunks

    def close(self) -> None: ...


class PtyFirmware:
    """The scripted firmware behind a real pty, in real time."""

    def __init__(self, firmware: ScriptedFirmware) -> None:
        self.firmware = firmware
        self.master, self.slave = os.openpty()
        tty.setraw(self.master)
        self.port = os.ttyname(self.slave)
        self.running = self.plugged = True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self) -> None:
        os.set_blocking(self.master, False)
        while self.running:
            now = time.monotonic()
            try:
                data = os.read(self.master, 4096)
            except BlockingIOError:
                data = b""
            os.write(self.master, self.firmware.receive(data, now) + self.firmware.tick(now))
            time.sleep(0.005)

    def rest(self) -> None:
        """The firmware falls silent; what it had said is gone."""
        self.running = False
        self.thread.join()
        termios.tcflush(self.slave, termios.TCIOFLUSH)

    def pull(self) -> None:
        """The cable is out."""
        if self.plugged:
            self.plugged = self.running = False
            self.thread.join()
            os.close(self.slave)
            os.close(self.master)


@pytest.fixture
def firmware() -> ScriptedFirmware:
    return ScriptedFirmware()


@pytest.fixture
def world(firmware: ScriptedFirmware) -> MemoryWorld:
    return MemoryWorld(firmware)


@pytest.fixture
def pty_firmware(firmware: ScriptedFirmware) -> Iterator[PtyFirmware]:
    peer = PtyFirmware(firmware)
    yield peer
    peer.pull()
