"""What a mission does about each fault that the firmware reports and each that it finds itself: one table.

The firmware acts first, by a table of its own (`firmware/core/src/supervisor.rs`): what it stops for it stops for,
whatever stands here. This table says what the mission makes of it. `fault_desk` carries it out, and nothing else does.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from rover.link.words import FaultCode
from rover.outcome import RunStatus
from rover.str_enum import StrEnum


class Check(StrEnum):
    """Faults that the mission finds by itself."""

    # More than half of the pictures of the last while do not fit the ground.
    FIXES_REFUSED = "FixesRefused"
    # Pictures fit less well than the camera's model promises, or show the ground off where wheels in a turn say it is.
    MOUNT_RESIDUAL = "MountResidual"
    # More than half of the cycles begin late.
    LATE_CYCLES = "LateCycles"
    # The firmware loses or cannot read much of what it is sent.
    WIRE_ERRORS = "WireErrors"
    # The two clocks do not agree well enough to say where the rover was when a picture was taken.
    CLOCK = "Clock"
    # Motion was commanded and acknowledged, and the wheels do not turn.
    NO_MOTION = "NoMotion"
    # No picture shows temperatures of ground.
    NO_SIGHT = "NoSight"
    # What is left in the battery is needed for the way back.
    BATTERY_RESERVE = "BatteryReserve"
    # Wheels and gyroscope disagree about how far the rover has turned.
    SLIPPING = "Slipping"
    # It leans by more than the vehicle may.
    STEEP = "Steep"
    # It lies on its side.
    TIPPED = "Tipped"
    # Somebody has lifted it, or turns it about.
    HANDLED = "Handled"
    # The log or the survey cannot be written.
    LOG = "Log"


class AtStart(Enum):
    """Whether a rover sets off with it. TAKEN_BACK: of the last drive; arming ends it."""

    TAKEN_BACK = auto()
    GOES = auto()
    REFUSED = auto()


class Driving(Enum):
    """What the mission does about it on the way."""

    # A line in the timeline, the first time.
    NOTE = auto()
    # Half the speed while it lasts.
    SLOW = auto()
    # To rest, until it has passed; when that takes too long the mission ends.
    WAIT = auto()
    # Back to the launch.
    HOME = auto()
    # The mission ends where the rover stands.
    END = auto()
    # The firmware has stopped the rover; it is armed again as often as `stops` allows.
    REARM = auto()


@dataclass(frozen=True)
class Row:
    """line: what the operator reads. wait_s: how long WAIT waits, seconds. status: of a mission that ends for it."""

    start: AtStart
    driving: Driving
    line: str
    wait_s: float = 0.0
    status: RunStatus = RunStatus.SAFETY_STOP


TAKEN_BACK, GOES, REFUSED = AtStart
NOTE, SLOW, WAIT, HOME, END, REARM = Driving

FIRMWARE: dict[FaultCode, Row] = {
    FaultCode.DEAD_MAN: Row(TAKEN_BACK, REARM, "the firmware heard nothing from the companion"),
    FaultCode.SONAR_GUARD: Row(TAKEN_BACK, REARM, "something was too close ahead"),
    FaultCode.LOW_BATTERY: Row(REFUSED, END, "the battery is too low to drive", status=RunStatus.PARTIAL),
    FaultCode.STALL: Row(TAKEN_BACK, REARM, "a wheel did not turn although it was driven"),
    FaultCode.ENCODER_LEFT: Row(REFUSED, END, "the left wheel's encoder tells nonsense"),
    FaultCode.ENCODER_RIGHT: Row(REFUSED, END, "the right wheel's encoder tells nonsense"),
    FaultCode.SONAR_DEAD: Row(REFUSED, WAIT, "a sonar does not answer: nobody would stop the rover there", 10.0),
    FaultCode.UNDERRUN: Row(TAKEN_BACK, REARM, "motion came too late"),
    FaultCode.SEGMENT_REJECTED: Row(GOES, NOTE, "the firmware has refused a piece of motion"),
    FaultCode.ARM_REFUSED: Row(GOES, NOTE, "the firmware has refused to arm"),
    FaultCode.QUEUE_FULL: Row(GOES, NOTE, "motion came faster than the firmware drives it"),
    FaultCode.TRANSMIT_OVERFLOW: Row(GOES, NOTE, "the wire does not take all that the firmware has to say"),
    FaultCode.RECEIVE_OVERFLOW: Row(GOES, NOTE, "the firmware was sent more than it can take"),
    FaultCode.SCHEMA_MISMATCH: Row(TAKEN_BACK, NOTE, "somebody with another protocol speaks to the firmware, too"),
    FaultCode.WATCHDOG: Row(TAKEN_BACK, END, "the board has been restarted by its watchdog"),
    FaultCode.INERTIAL_LOST: Row(GOES, NOTE, "the inertial sensor is not believed: wheels and camera do without"),
}
"""Every fault of the protocol but None."""

CHECKS: dict[Check, Row] = {
    Check.FIXES_REFUSED: Row(GOES, SLOW, "most pictures do not fit the ground that the rover knows"),
    Check.MOUNT_RESIDUAL: Row(GOES, NOTE, "the camera sits otherwise than its file says, or its lens bends more"),
    Check.LATE_CYCLES: Row(GOES, SLOW, "most cycles begin late: the computer is too slow, or busy"),
    Check.WIRE_ERRORS: Row(GOES, SLOW, "the firmware cannot read much of what it is sent: look at the wire"),
    Check.CLOCK: Row(GOES, SLOW, "the clocks of firmware and companion do not agree"),
    Check.NO_MOTION: Row(GOES, END, "the firmware acknowledges motion and the wheels do not turn"),
    Check.NO_SIGHT: Row(REFUSED, WAIT, "the camera shows nothing", 30.0),
    Check.BATTERY_RESERVE: Row(REFUSED, HOME, "the battery is needed for the way back"),
    Check.SLIPPING: Row(GOES, SLOW, "the wheels slip: they turn otherwise than the rover"),
    Check.STEEP: Row(REFUSED, END, "the ground is steeper than the vehicle may climb"),
    Check.TIPPED: Row(REFUSED, END, "the rover has fallen over"),
    Check.HANDLED: Row(REFUSED, WAIT, "somebody holds the rover: its place will be another one", 60.0),
    Check.LOG: Row(REFUSED, END, "the log or the survey cannot be written", status=RunStatus.PARTIAL),
}
"""Every check of the mission."""
