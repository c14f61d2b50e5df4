"""A board with both wires: who commands, what the other wire is told, and a controller whose INT is shorted."""

from __future__ import annotations

import pytest
from rover.errors import PreflightFailed
from rover_protocol import messages

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator import wiring

from .emulator_desk import DRIVER, Desk

pytestmark = pytest.mark.rig("emulator")

OTHER = 2


@pytest.fixture
def desk() -> Desk:
    try:
        return Desk()
    except PreflightFailed as missing:
        pytest.skip(str(missing))


def test_a_bus_hears_that_the_rover_lives_before_anybody_has_said_hello(desk: Desk) -> None:
    desk.run(1200)
    assert list(desk.bus_heard) == ["State"]
    assert desk.bus_heard["State"]["state"] == messages.STATE_DISARMED


def test_a_companion_on_the_bus_is_told_who_drives_over_the_line_and_may_only_stop(desk: Desk) -> None:
    desk.arm_over_the_line()
    desk.put("Hello", schema_hash=messages.SCHEMA_HASH, session=OTHER)
    desk.put("KeepAlive", counter=9)
    desk.run(50, alive=True)
    assert desk.bus_heard["HelloBusy"] == {"session": OTHER, "holder": DRIVER, "wire": messages.HELLO_BUSY_WIRE_SERIAL}
    assert "HelloReply" not in desk.bus_heard
    desk.put("Arm", token=2, session=OTHER)
    desk.run(300, alive=True)
    assert desk.line_heard["State"]["state"] == messages.STATE_ARMED, "the line feeds and hears the rover as before"
    desk.put("EmergencyStop", reason=3)
    desk.run(20, alive=True)
    assert desk.line_heard["State"]["state"] == messages.STATE_LATCHED
    desk.put("Hello", schema_hash=messages.SCHEMA_HASH, session=OTHER)
    desk.run(50)
    assert desk.bus_heard["HelloBuild"]["accepted"] == 1, "with the motors off the rover is free"


def test_an_interrupt_pin_on_ground_costs_the_bus_and_not_the_rover(desk: Desk) -> None:
    desk.arm_over_the_line()
    desk.chip.ground(wiring.CAN_INTERRUPT, True)
    desk.run(600, alive=True)
    assert not desk.chip.watchdog._reason, "no reset"
    assert desk.line_heard["State"]["state"] == messages.STATE_ARMED
    assert b"CAN: INT is low without a reason" in desk.log
    desk.chip.ground(wiring.CAN_INTERRUPT, False)
    desk.bus_heard.clear()
    desk.run(2500, alive=True)
    assert "State" in desk.bus_heard, "it is taken up again"
