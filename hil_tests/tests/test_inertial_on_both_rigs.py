"""The firmware makes the same of an inertial sensor on the emulated board and on the desktop, tick for tick."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest
from rover.errors import PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover_hil.firmware_process import FirmwareProcess, emulator_command, sitl_command
from rover_protocol import framing, messages
from rover_protocol.rig_tick import TickReply, TickRequest

pytestmark = pytest.mark.rig("emulator")

MILLISECONDS = 2_600
TURNING, SILENT = range(1_600, 2_000), range(2_200, 2_350)
INERTIAL_LOST = 16
HEARD = ("InertialHeading", "Gravity", "Fault")


def said(command: Sequence[str]) -> list[tuple[str, dict[str, int | bytes]]]:
    """What the firmware says of a sensor with a bias that leans, turns, falls silent and comes back."""
    process, decoder, noise = (
        FirmwareProcess(list(command), DEFAULT_BAUD, "serial"),
        framing.Decoder(),
        random.Random(3),
    )
    heard, sent = [], 0
    for millisecond in range(1, 1 + MILLISECONDS):
        x, y, z, along, aside, up = (noise.randint(-5, 5) for _ in range(6))
        request = TickRequest(
            now_us=1000 * millisecond,
            battery_mv=7400,
            inertial=0 if millisecond in SILENT else 1,
            gyro_x=x,
            gyro_y=y,
            gyro_z=z + (2000 if millisecond in TURNING else 30),
            acceleration_x=along + 200,
            acceleration_y=aside,
            acceleration_z=up + 16_393,
            temperature=100 + millisecond // 500,
        )
        process.stdin.write(request.pack())
        process.stdin.flush()
        total = TickReply.unpack(process.stdout.read(TickReply.SIZE)).bytes_sent
        for identifier, _, payload in decoder.feed(process.receive(total - sent)):
            message, fields = messages.decode(identifier, payload)
            if message.name in HEARD:
                heard.append((message.name, fields))
        sent = total
    process.close()
    return heard


def test_both_rigs_say_the_same_of_turns_tilt_loss_and_return() -> None:
    try:
        on_desktop, on_board = said(sitl_command()), said(emulator_command())
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    assert on_desktop == on_board
    faults = [(fields["code"], fields["active"]) for name, fields in on_desktop if name == "Fault"]
    assert [active for code, active in faults if code == INERTIAL_LOST] == [1, 0]
    headings = [int(fields["heading"]) for name, fields in on_desktop if name == "InertialHeading"]
    assert max(headings) - min(headings) > 100_000
    assert len(on_desktop) > 150
