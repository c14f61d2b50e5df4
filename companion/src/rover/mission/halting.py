"""A rover that the firmware has stopped: what is noted, and whether it is armed again."""

from __future__ import annotations

from rover.link.telemetry import FirmwareState
from rover.link.words import MotorState, StopCause
from rover.mission.conduct import Conduct
from rover.mission.contacts import BACK_OFF_M, BACK_OFF_SPEED
from rover.mission.orders import Orders
from rover.mission.phase import Event
from rover.mission.stops import REARM_DELAY_S


def halt(survey: Conduct, now: float, firmware: FirmwareState) -> None:
    """The firmware has stopped the rover and thrown its queue away."""
    survey.drive.halted(now)
    survey.stops.add(firmware.cause)
    survey.note(now, f"the firmware stopped the rover: {firmware.cause}")
    if firmware.cause == StopCause.BUMPER:
        survey.contacts.touch(survey.perception.pose, survey.vehicle)
    survey.happen(Event.STOPPED, now)


def recover(survey: Conduct, now: float, firmware: FirmwareState) -> Orders:
    """Arms it again, unless the mission is to end here, somebody is to decide, or it has happened too often."""
    end = survey.conclusion.end
    if firmware.state in (MotorState.ARMED, MotorState.MOVING):
        survey.happen(Event.REARMED, now)
        if survey.stops.last == StopCause.BUMPER:
            survey.drive.back_off(BACK_OFF_M, BACK_OFF_SPEED)
    elif firmware.state == MotorState.STOPPING or now - survey.since < REARM_DELAY_S:
        pass
    elif end is not None and end.stay:
        survey.conclude(now)
    elif survey.stops.too_many(firmware.cause):
        survey.abort(survey.stops.outcome(firmware.cause))
        survey.conclude(now)
    elif survey.holds:
        survey.heed(now)
    else:
        survey.since = now
        return Orders(arm=True)
    return Orders()
