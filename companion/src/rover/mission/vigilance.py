"""What is heeded every cycle whatever the rover is about: each thing brakes, holds the rover, or ends the mission."""

from __future__ import annotations

from collections.abc import Sequence

from rover.capture.frame import Frame
from rover.link.telemetry import FirmwareState, Telemetry
from rover.link.words import MotorState
from rover.mission.conduct import Conduct
from rover.mission.fault_desk import FaultDesk
from rover.mission.holds import QUESTION, QUESTION_LIMIT_S
from rover.mission.phase import Phase
from rover.outcome import Outcome, RunStatus


def heed(survey: Conduct, now: float) -> None:
    """Nobody drives blind, astray, beyond the time or the battery."""
    perception, way_back = survey.perception, survey.way_back_s()
    lost_place = survey.phase is not Phase.SEEK and not perception.placed
    in_hand = way_back if survey.mission.return_home else 0.0
    concerns = survey.watch.check(now, perception.relative_sigma, lost_place, in_hand)
    for note in concerns.notes:
        survey.note(now, note)
        survey.drive.stop()
    if concerns.end is not None:
        survey.abort(concerns.end, concerns.home)
    if survey.gauge.spent(way_back):
        left = survey.gauge.left_wh or 0.0
        why = f"the battery is needed for the way back: {left:.1f} Wh are left until it is too low to drive"
        survey.abort(Outcome(RunStatus.PARTIAL, why), home=True)
    late = survey.holds.expired(now)
    if late is not None:
        survey.abort(Outcome(RunStatus.PARTIAL, f"nothing came of waiting: {late}"))


def heed_faults(
    survey: Conduct,
    desk: FaultDesk,
    now: float,
    telemetry: Sequence[Telemetry],
    frames: Sequence[Frame],
    firmware: FirmwareState,
) -> None:
    """What the firmware reports and what the mission finds by itself, by the table of faults."""
    checks, fix = survey.checks, survey.perception.last_fix
    checks.take(now, telemetry, fix if any(not frame.ffc for frame in frames) else None)
    if firmware.state in (MotorState.ARMED, MotorState.MOVING):
        checks.moved(now, survey.drive.commanded, survey.odometer.travel)
    else:
        checks.stands()
    desk.take(telemetry)
    active = checks.active | survey.perception.handling.active
    desk.act(survey, now, firmware, active, checks.details)


def heed_gap(survey: Conduct, now: float) -> None:
    """A companion that was suspended finds another world: power does not return without a decision."""
    gap = survey.watch.gap
    if gap is None or survey.phase is Phase.START:
        return
    line = f"the companion stood still for {gap:.0f} s"
    if survey.attended:
        survey.hold(now, QUESTION, f"{line}: is the rover to drive on? (rover tell RUN go)", now + QUESTION_LIMIT_S)
    else:
        survey.abort(Outcome(RunStatus.PARTIAL, line))
