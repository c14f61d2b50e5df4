"""The firmware on a CAN bus: as a host with a serial CAN adapter sees it, and as python-can does."""

from __future__ import annotations

import os
import time
import tty

import can
import pytest
from rover_protocol import messages

from protocol.tests.firmware_process import CanText, Conversation, Firmware


@pytest.fixture
def talk():
    conversation = Conversation("can")
    yield conversation
    conversation.close()


def test_handshake_arming_and_the_dead_man_work_as_on_the_serial_line(talk: Conversation) -> None:
    talk.arm()
    assert talk.last["HelloBuild"]["accepted"] == 1
    silent = 0
    while talk.firmware.powered:
        talk.run(1)
        silent += 1
    assert 290 < silent < 400
    talk.run(2)
    assert talk.last["State"]["cause"] == messages.STATE_CAUSE_DEAD_MAN


def test_nothing_is_said_on_the_bus_before_a_hello_came_by_it(talk: Conversation) -> None:
    talk.run(500)
    assert talk.heard == []
    talk.send(messages.Stop, reason=3)
    talk.run(5)
    assert talk.heard == []
    talk.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=1)
    talk.run(100)
    # The stop had been taken all the same.
    assert talk.last["State"]["state"] == messages.STATE_LATCHED
    assert "WheelTicks" in talk.last


def test_a_clock_exchange_on_an_idle_bus_takes_less_than_four_milliseconds_and_says_where_it_was(
    talk: Conversation,
) -> None:
    talk.arm()
    for number in range(50):
        asked = talk.firmware.now_us
        talk.last.pop("ClockReply", None)
        talk.send(messages.ClockRequest, sequence=number)
        for _ in range(4):
            if "ClockReply" not in talk.last:
                talk.run(1)
        reply = talk.last["ClockReply"]
        assert reply["sequence"] == number
        assert asked <= reply["receive_time"] <= reply["receive_time"] + reply["turnaround"] <= talk.firmware.now_us
        talk.send(messages.KeepAlive, counter=number)


def test_the_same_lines_give_the_same_bytes() -> None:
    def run() -> list[tuple[str, dict[str, int]]]:
        talk = Conversation("can")
        talk.arm()
        talk.run(400)
        talk.close()
        return talk.heard

    assert run() == run()


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"V\r", b"V0101\r"),
        (b"N\r", b"NROVR\r"),
        (b"F\r", b"F00\r"),
        (b"\r\r", b""),
        (b"S5\r", b"\a"),
        (b"t01010\r", b"\a"),
        (b"x" * 500 + b"\r", b"\a"),
        (b"T000000101FF\r", b""),
    ],
)
def test_the_adapter_answers_as_such_adapters_do(line: bytes, answer: bytes) -> None:
    firmware = Firmware("can")
    firmware.send(CanText.opening)
    assert firmware.tick() == b"\r\r\r"
    firmware.send(line)
    assert firmware.tick() == answer
    firmware.close()


def test_a_closed_channel_takes_no_frames_and_a_full_adapter_says_so() -> None:
    firmware = Firmware("can")
    firmware.send(b"t010107\r")
    assert firmware.tick() == b"\a"
    firmware.send(b"O\r" + b"t010107\r" * 65)
    assert firmware.tick() == b"\r\a"
    firmware.send(b"F\rF\r")
    assert firmware.tick() == b"F02\rF00\r"
    firmware.close()


def test_python_can_opens_it_and_talks_to_the_rover() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    firmware = Firmware("can", descriptor=master)
    hello = messages.Hello.pack(schema_hash=messages.SCHEMA_HASH, session=7)
    wanted = {"HelloReply", "HelloBuild", "State", "WheelTicks"}
    names: set[str] = set()
    with can.Bus(interface="slcan", channel=os.ttyname(slave), bitrate=500_000, sleep_after_open=0.0) as bus:
        for _ in range(30):
            firmware.tick()
        bus.send(can.Message(arbitration_id=messages.Hello.ID, data=hello, is_extended_id=False))
        end = time.monotonic() + 5.0
        while not names >= wanted and time.monotonic() < end:
            firmware.tick()
            while (message := bus.recv(0.0005)) is not None:
                names.add(messages.decode(message.arbitration_id, bytes(message.data))[0].name)
    firmware.close()
    os.close(slave)
    assert names >= wanted
