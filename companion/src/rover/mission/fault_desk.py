"""Carries out the table of faults: what is active now, what is new, what has passed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rover.link.telemetry import FaultReport, FirmwareState, Telemetry
from rover.link.words import FaultCode
from rover.mission.conduct import Conduct
from rover.mission.fault_table import CHECKS, FIRMWARE, AtStart, Check, Driving, Row
from rover.mission.phase import Phase
from rover.outcome import Outcome, RunStatus

# A fault that a firmware of another version may report.
UNKNOWN = "the firmware reports {}, which this version does not know"


class FaultDesk:
    """Of one mission."""

    def __init__(self) -> None:
        self._active: set[str] = set()
        self._counted: set[str] = set()

    def take(self, telemetry: Sequence[Telemetry]) -> None:
        """Faults that are counted only are never active: the report of one is all there is."""
        for event in telemetry:
            row = row_of(event.code) if isinstance(event, FaultReport) and event.count > 0 else None
            if isinstance(event, FaultReport) and row is not None and row.driving is Driving.NOTE:
                self._counted.add(event.code)

    def act(
        self,
        survey: Conduct,
        now: float,
        firmware: FirmwareState,
        checks: Iterable[Check],
        details: Mapping[Check, str] | None = None,
    ) -> None:
        """Does what the table says about everything that has come or gone since the last cycle.

        `details`: what the operator reads of a check in place of its line.
        """
        told = {check.value: detail for check, detail in (details or {}).items()}
        active = {*firmware.faults, *self._counted, *checks}
        for name in sorted(active - self._active):
            self._begin(survey, now, name, told.get(name))
        for name in sorted(self._active - active):
            self._end(survey, now, name)
        self._active = active

    def _begin(self, survey: Conduct, now: float, name: str, detail: str | None) -> None:
        row = row_of(name)
        if row is None:
            survey.note(now, UNKNOWN.format(name))
            return
        line = detail or f"{row.line} ({name})"
        if survey.phase is Phase.START:
            if row.start is AtStart.REFUSED:
                survey.abort(Outcome(row.status, f"{line}: not armed"))
            return
        match row.driving:
            case Driving.NOTE:
                survey.note(now, line)
            case Driving.SLOW:
                survey.note(now, f"{line}: half the speed")
                survey.drive.slow(name, True)
            case Driving.WAIT:
                survey.hold(now, name, line, now + row.wait_s)
            case Driving.HOME:
                survey.abort(Outcome(RunStatus.PARTIAL, line), home=True)
            case Driving.END if survey.phase is not Phase.HALTED:  # what the firmware stops for is judged with the stop
                survey.abort(Outcome(row.status, line))
            case _:
                pass

    def _end(self, survey: Conduct, now: float, name: str) -> None:
        row = row_of(name)
        if row is not None and row.driving is Driving.SLOW:
            survey.note(now, f"{name} has passed: full speed")
            survey.drive.slow(name, False)
        if row is not None and row.driving is Driving.WAIT and survey.holds.release(name):
            survey.note(now, f"{name} has passed")


def row_of(name: str) -> Row | None:
    """The row of a fault of the firmware or of a check; None for what this version does not know."""
    if name in list(Check):
        return CHECKS[Check(name)]
    return FIRMWARE.get(FaultCode(name)) if name in list(FaultCode) else None
