"""Every fault leads to something: each row of the table is there, is reached, and does what it says."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from rover.link.telemetry import FaultReport, LinkQuality
from rover.link.words import FaultCode, MotorState, StopCause
from rover.mission.checks import Checks
from rover.mission.fault_table import CHECKS, FIRMWARE, AtStart, Check, Driving, Row
from rover.mission.phase import Phase
from rover.mission.sight import BLIND_AFTER, SHUT_AFTER
from rover.outcome import RunStatus
from rover.vision.localization.fix import Fix
from rover_protocol import messages

from companion.tests.mission.imagined_rover import CYCLE, Imagined, ImaginedRover, a_mission

COUNTED_ONLY = (
    *(FaultCode.SEGMENT_REJECTED, FaultCode.ARM_REFUSED, FaultCode.QUEUE_FULL),
    *(FaultCode.TRANSMIT_OVERFLOW, FaultCode.RECEIVE_OVERFLOW),
)
STOPS_WITH = {
    FaultCode.DEAD_MAN: StopCause.DEAD_MAN,
    FaultCode.SONAR_GUARD: StopCause.SONAR_GUARD,
    FaultCode.STALL: StopCause.STALL,
    FaultCode.UNDERRUN: StopCause.UNDERRUN,
}
Trouble = Callable[[ImaginedRover], None]
"""Keeps a fault of the mission's own there for one cycle."""


def rows(driving: Driving, of: dict[FaultCode, Row] = FIRMWARE) -> list[FaultCode]:
    return [fault for fault, row in of.items() if row.driving is driving]


def driving() -> ImaginedRover:
    rover = ImaginedRover(a_mission(6.0, 6.0))
    while rover.perception.pose.distance(rover.mission.launch.pose) < 0.5:
        rover.step()
    return rover


def drives_within(rover: ImaginedRover, seconds: float) -> bool:
    end = rover.now + seconds
    while rover.now < end and not rover.has_ended():
        rover.step()
        if rover.phase is Phase.DRIVE and rover.moved:
            return True
    return False


def test_every_fault_of_the_protocol_and_every_check_has_a_row() -> None:
    assert {fault.value for fault in FIRMWARE} == set(messages.VALUES["Fault"]["code"].values()) - {"None"}
    assert set(CHECKS) == set(Check)


def test_every_row_has_a_line_and_what_waits_has_a_limit() -> None:
    for row in (*FIRMWARE.values(), *CHECKS.values()):
        assert row.line
        assert (row.wait_s > 0.0) == (row.driving is Driving.WAIT)
    assert len({row.line for row in (*FIRMWARE.values(), *CHECKS.values())}) == len(FIRMWARE) + len(CHECKS)


@pytest.mark.parametrize("fault", FIRMWARE)
def test_at_the_start_it_is_armed_or_not_as_the_row_says(fault: FaultCode) -> None:
    rover = ImaginedRover(world=Imagined(state=MotorState.DISARMED, faults=(fault.value,)))
    armed = False
    for _ in range(20):
        armed = rover.step().arm or armed
    assert armed == (FIRMWARE[fault].start is not AtStart.REFUSED)
    if not armed:
        assert rover.outcome is not None
        assert (rover.outcome.status, FIRMWARE[fault].line in rover.outcome.reason) == (FIRMWARE[fault].status, True)


@pytest.mark.parametrize("fault", rows(Driving.NOTE))
def test_what_is_only_told_is_told_once_and_the_mission_goes_on(fault: FaultCode) -> None:
    rover = driving()
    for count in range(1, 5):
        if fault in COUNTED_ONLY:
            rover.said = [FaultReport(rover.now, fault.value, False, count, 0)]
        else:
            rover.become(faults=(fault.value,))
        rover.run(1.0)
    assert sum(FIRMWARE[fault].line in note for note in rover.notes) == 1
    assert drives_within(rover, 20.0)


@pytest.mark.parametrize("fault", rows(Driving.WAIT))
def test_what_is_waited_for_holds_the_rover_until_it_has_passed(fault: FaultCode) -> None:
    rover = driving()
    rover.become(faults=(fault.value,))
    rover.run(0.5 * FIRMWARE[fault].wait_s)
    assert rover.phase is Phase.PAUSED
    assert FIRMWARE[fault].line in rover.survey.holds.line
    rover.become(faults=())
    assert drives_within(rover, 20.0)


@pytest.mark.parametrize("fault", rows(Driving.WAIT))
def test_what_does_not_pass_ends_the_mission(fault: FaultCode) -> None:
    rover = driving()
    rover.become(faults=(fault.value,))
    rover.run(2.0 * FIRMWARE[fault].wait_s)
    assert rover.outcome is not None
    assert FIRMWARE[fault].line in rover.outcome.reason
    assert not rover.moved


def test_a_rover_that_the_firmware_stopped_for_a_lost_sonar_is_armed_again_only_when_it_answers() -> None:
    rover = driving()
    fault = FaultCode.SONAR_DEAD.value
    rover.become(state=MotorState.LATCHED, cause=StopCause.SENSOR_LOST, faults=(fault,))
    for _ in range(50):
        assert not rover.step().arm
    rover.become(faults=())
    assert any(rover.step().arm for _ in range(20))
    rover.become(state=MotorState.ARMED)
    assert drives_within(rover, 20.0)


@pytest.mark.parametrize("fault", rows(Driving.END))
def test_what_ends_the_mission_ends_it_at_rest_with_the_rows_line(fault: FaultCode) -> None:
    rover = driving()
    rover.become(faults=(fault.value,))
    rover.run(10.0)
    assert rover.outcome is not None
    assert rover.outcome.status is FIRMWARE[fault].status
    assert FIRMWARE[fault].line in rover.outcome.reason
    assert rover.survey.drive.at_rest(rover.now)


@pytest.mark.parametrize("fault", rows(Driving.REARM))
def test_what_the_firmware_stops_for_is_gone_on_after(fault: FaultCode) -> None:
    rover = driving()
    rover.become(state=MotorState.LATCHED, cause=STOPS_WITH[fault].value, faults=(fault.value,))
    assert any(rover.step().arm for _ in range(20))
    rover.become(state=MotorState.ARMED, faults=())
    assert drives_within(rover, 20.0)


def test_a_fault_of_another_version_is_told_and_nothing_more() -> None:
    rover = driving()
    rover.become(faults=("Unknown15",))
    rover.run(1.0)
    assert any("Unknown15" in note for note in rover.notes)
    assert drives_within(rover, 20.0)


# -- what the mission finds by itself ----------------------------------------------------------------------------


def refused(rover: ImaginedRover) -> None:
    rover.perception.last_fix = Fix(rover.now, False, "no match")


def ill_fitting(rover: ImaginedRover) -> None:
    rover.perception.last_fix = Fix(rover.now, True, inliers=40, residual_px=6.0)


def noisy(rover: ImaginedRover) -> None:
    frames = round(50.0 * rover.now)
    rover.said = [LinkQuality(rover.now, frames, frames // 2, 0, 0)]


def apart(rover: ImaginedRover) -> None:
    rover.survey.checks.clock(0.2)


def late(rover: ImaginedRover) -> None:
    if not isinstance(rover.survey.checks, EveryCycleLate):
        rover.survey.checks = EveryCycleLate()


class EveryCycleLate(Checks):
    def __init__(self) -> None:
        super().__init__(late_s=0.5 * CYCLE)


def kept(rover: ImaginedRover, trouble: Trouble, seconds: float) -> None:
    end = rover.now + seconds
    while rover.now < end and not rover.has_ended():
        trouble(rover)
        rover.step()


@pytest.mark.parametrize(
    ("check", "trouble"),
    [
        (Check.FIXES_REFUSED, refused),
        (Check.WIRE_ERRORS, noisy),
        (Check.CLOCK, apart),
        (Check.LATE_CYCLES, late),
    ],
)
def test_what_makes_careful_halves_the_speed_while_it_lasts(check: Check, trouble: Trouble) -> None:
    assert CHECKS[check].driving is Driving.SLOW
    rover = driving()
    full = rover.survey.drive.cruise_speed
    kept(rover, trouble, 60.0)
    assert check in rover.survey.checks.active
    assert any(CHECKS[check].line in note for note in rover.notes)
    assert rover.survey.drive.cruise_speed == pytest.approx(0.5 * full)
    fastest = 0.0
    for _ in range(200):
        trouble(rover)
        rover.step()
        speed = rover.survey.drive.committed.state_at(rover.now).speed
        fastest = max(fastest, abs(speed))
    assert 0.0 < fastest <= 0.55 * full


def test_after_that_it_drives_as_before() -> None:
    rover = driving()
    full = rover.survey.drive.cruise_speed
    rover.survey.checks.clock(0.2)
    rover.run(5.0)
    rover.survey.checks.clock(0.001)
    rover.run(5.0)
    assert rover.survey.drive.cruise_speed == full
    assert "Clock has passed: full speed" in rover.notes


def test_a_camera_that_sits_otherwise_is_told() -> None:
    assert CHECKS[Check.MOUNT_RESIDUAL].driving is Driving.NOTE
    rover = driving()
    kept(rover, ill_fitting, 10.0)
    assert sum(CHECKS[Check.MOUNT_RESIDUAL].line in note for note in rover.notes) == 1
    assert not rover.has_ended()


def test_wheels_that_do_not_turn_are_noticed_within_two_seconds() -> None:
    assert CHECKS[Check.NO_MOTION].driving is Driving.END
    rover = driving()
    while not (rover.phase is Phase.DRIVE and rover.moved):
        rover.step()
    rover.become(wheels=False)
    stuck = rover.now
    while not rover.has_ended():
        rover.step()
        assert rover.now - stuck < 3.5
        if rover.survey.conclusion.end is not None:
            assert rover.now - stuck < 2.0 + 2.0 * CYCLE
            break
    rover.run(5.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.SAFETY_STOP
    assert CHECKS[Check.NO_MOTION].line in rover.outcome.reason


def test_without_sight_the_rover_waits_and_goes_on_and_ends_when_it_does_not_come_back() -> None:
    assert (CHECKS[Check.NO_SIGHT].driving, CHECKS[Check.NO_SIGHT].wait_s) == (Driving.WAIT, SHUT_AFTER)
    rover = driving()
    rover.become(shutter=True)
    rover.run(BLIND_AFTER + 4.0)
    assert not rover.moved
    rover.become(shutter=False)
    assert drives_within(rover, 20.0)
    rover.become(shutter=True)
    rover.run(SHUT_AFTER + 5.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.PARTIAL


def test_what_cannot_be_kept_any_more_ends_the_mission_at_rest_and_says_why() -> None:
    row = CHECKS[Check.LOG]
    assert (row.driving, row.status) == (Driving.END, RunStatus.PARTIAL)
    rover = driving()
    rover.survey.checks.kept("the log can no longer be written: No space left on device")
    rover.run(10.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.PARTIAL
    assert rover.outcome.reason == "the log can no longer be written: No space left on device"
    assert rover.survey.drive.at_rest(rover.now)


def test_a_rover_whose_log_cannot_be_written_is_not_armed() -> None:
    assert CHECKS[Check.LOG].start is AtStart.REFUSED
    rover = ImaginedRover(world=Imagined(state=MotorState.DISARMED))
    rover.survey.checks.kept("the disk is nearly full: 3 MB are left")
    assert not any(rover.step().arm for _ in range(20))
    assert rover.outcome is not None
    assert rover.outcome.reason == "the disk is nearly full: 3 MB are left: not armed"


def test_a_battery_that_is_needed_for_the_way_back_sends_it_home() -> None:
    assert CHECKS[Check.BATTERY_RESERVE].driving is Driving.HOME
    rover = driving()
    rover.become(volts=6.25)
    rover.run(10.0)
    assert rover.phase is Phase.HOME
