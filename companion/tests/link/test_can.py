"""The link over CAN: names of ports, python-can's virtual bus, and slcan over a real pty."""

from __future__ import annotations

import contextlib
import os
import threading
import time
import tty
from collections.abc import Iterator

import can
import pytest
from rover.errors import BadInput, PreflightFailed
from rover.link.clock import WallClock
from rover.link.opening import open_frames
from rover.link.port import CanPort, parse_port
from rover.link.session import Link
from rover_protocol import framing, messages


class BusFirmware:
    """The scripted firmware as a node of a bus, in real time: one frame for each message."""

    def __init__(self, firmware, bus: can.BusABC) -> None:
        self.firmware = firmware
        self.bus = bus
        self.decoder = framing.Decoder()
        self.running = True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self) -> None:
        while self.running:
            message = self.bus.recv(timeout=0.005)
            now = time.monotonic()
            said = self.firmware.tick(now)
            while message is not None:
                said += self.firmware.receive(framing.encode(message.arbitration_id, 0, bytes(message.data)), now)
                message = self.bus.recv(timeout=0.0)
            for identifier, _, payload in self.decoder.feed(said):
                self.bus.send(can.Message(arbitration_id=identifier, data=payload, is_extended_id=False))

    def leave(self) -> None:
        if self.running:
            self.running = False
            self.thread.join()
            self.bus.shutdown()


@pytest.fixture
def virtual_bus(firmware) -> Iterator[BusFirmware]:
    node = BusFirmware(firmware, can.Bus(interface="virtual", channel="rover"))
    yield node
    node.leave()


def drive(link: Link, seconds: float) -> None:
    end = link.clock.now() + seconds
    while link.clock.now() < end:
        link.poll()
        link.clock.advance(link.clock.now() + 0.02)


@pytest.mark.parametrize(
    ("name", "parsed"),
    [
        ("/dev/ttyACM0", "/dev/ttyACM0"),
        ("can:socketcan:can0", CanPort("socketcan", "can0")),
        ("can:slcan:/dev/ttyUSB0@3000000", CanPort("slcan", "/dev/ttyUSB0@3000000")),
    ],
)
def test_a_port_is_a_serial_device_or_a_bus(name, parsed) -> None:
    assert parse_port(name) == parsed


@pytest.mark.parametrize("name", ["can:", "can:can0", "can:slcan:", "can::can0"])
def test_half_a_name_of_a_bus_is_refused_with_an_example(name) -> None:
    with pytest.raises(BadInput, match="can:socketcan:can0"):
        parse_port(name)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("can:slcan:/nowhere/tty", "cannot open the port can:slcan:/nowhere/tty: No such file"),
        ("can:nosuch:0", "cannot open the port can:nosuch:0: .*nosuch"),
    ],
)
def test_a_bus_that_does_not_open_is_a_preflight_failure_in_one_line(name, why) -> None:
    with pytest.raises(PreflightFailed, match=why) as error:
        open_frames(name)
    assert "\n" not in str(error.value)


def test_a_whole_session_over_a_bus(virtual_bus) -> None:
    clock = WallClock()
    link = Link(open_frames("can:virtual:rover", clock=clock), clock)
    assert link.connect().board == "Sitl"
    link.arm()
    drive(link, 0.3)
    assert "ClockRequest" in virtual_bus.firmware.received
    figures = link.figures()
    assert figures.frames_received > 30
    assert (figures.lost, figures.checksum_errors, figures.malformed) == (0, 0, 0)
    assert figures.bytes_received > 0
    link.close()


def test_other_traffic_of_the_bus_is_left_alone(virtual_bus) -> None:
    clock = WallClock()
    link = Link(open_frames("can:virtual:rover", clock=clock), clock)
    link.connect()
    for other in (
        can.Message(arbitration_id=0x18, is_extended_id=True, data=b"\1\2"),
        can.Message(arbitration_id=0x60, is_extended_id=False, is_remote_frame=True, dlc=8),
        can.Message(arbitration_id=0x7AA, is_extended_id=False, data=b"hello"),
    ):
        virtual_bus.bus.send(other)
    drive(link, 0.1)
    assert link.figures().unknown == 1, "of the three only the last could have been ours"
    link.close()


class Pty:
    """A raw pty whose master the test holds."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.port = CanPort("slcan", os.ttyname(self.slave))


@pytest.fixture
def pty() -> Iterator[Pty]:
    made = Pty()
    yield made
    os.close(made.master)
    os.close(made.slave)


def slcan(name: str, **raw: int) -> bytes:
    message = messages.BY_NAME[name]
    return f"t{message.ID:03X}{message.LENGTH}{message.pack(**raw).hex().upper()}\r".encode()


def test_slcan_over_a_pty_in_real_time(pty, firmware) -> None:
    """The peer of the bus is python-can's own slcan on a second pty, joined to the first by two threads."""
    other = Pty()
    ends = [(pty.master, other.master), (other.master, pty.master)]

    def carry(source: int, sink: int) -> None:
        rest = b""
        with contextlib.suppress(OSError):
            while data := os.read(source, 4096):
                *lines, rest = (rest + data).split(b"\r")
                # An adapter takes its commands itself and passes frames on.
                os.write(sink, b"".join(line + b"\r" for line in lines if line.startswith(b"t")))

    for source, sink in ends:
        threading.Thread(target=carry, args=(source, sink), daemon=True).start()
    peer = can.Bus(interface="slcan", channel=other.port.channel, bitrate=500_000, sleep_after_open=0.0)
    node = BusFirmware(firmware, peer)
    clock = WallClock()
    link = Link(open_frames(pty.port.name, clock=clock), clock)
    assert link.connect().version == "0.1.0"
    link.close()
    node.leave()
    for end in (other.master, other.slave):
        os.close(end)
