"""The loop of a mission: what the rig hands over goes into the survey, what the survey orders goes out over the link.

Everything that enters the survey enters through `_cycle` and is written down there; everything that it decides, too.
A replay runs this same loop over a recorded rig, with a journal that compares.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from rover.errors import LinkLost, PreflightFailed, SafetyStop
from rover.link.rig import Rig
from rover.link.session import Link
from rover.mission.goals import GoalState
from rover.mission.survey import Orders, Survey
from rover.mission.track import Track
from rover.outcome import Outcome, RunStatus
from rover.record.journal import Journal
from rover.record.topics import FIX, OPERATOR, PLACES, RIG_LOST, SEGMENTS, VERDICT_ASKED

CYCLE = 0.02
STATUS_PERIOD = 0.5
# After the mission's end the rover is disarmed; this long the link may take to confirm it.
DISARM_TIMEOUT = 2.0


@dataclass
class Control:
    """What the operator wants, set from signal handlers and polled by the loop."""

    stop: bool = False
    emergency: bool = False


@dataclass(frozen=True)
class Status:
    """One moment of a mission for the live display. Angles in radians, lengths in metres."""

    time: float
    phase: str
    firmware: str
    x: float
    y: float
    heading: float
    sigma: float
    goals_done: int
    goals: int
    indications: int
    surveyed: float
    battery: float | None
    lost_frames: int
    round_trip: float
    wall: float


class MissionLoop:
    """The loop of one mission over one link."""

    def __init__(
        self,
        survey: Survey,
        rig: Rig,
        journal: Journal,
        on_status: Callable[[Status], None] | None,
        control: Control,
        seed: int,
        keep: Callable[[float], str | None] = lambda now: None,
    ) -> None:
        """`keep`: called every cycle to keep what has been learned; says why it can't, which ends the mission."""
        self.survey = survey
        self.rig = rig
        self.track = Track()
        self.journal = journal
        self.link = Link(rig.transport, rig, session=seed & 0xFFFF, tap=journal.link)
        self._on_status = on_status
        self._control = control
        self._keep = keep
        self._status_due = 0.0
        self._begin = time.monotonic()
        self._noted = 0
        self._decisions = 0
        self._obeyed = (False, False)
        self._places: list[dict[str, Any]] = []

    def drive(self) -> None:
        """From the handshake to the survey's outcome; a lost link or a restarted firmware is an outcome too."""
        survey = self.survey
        self.link.connect()
        try:
            while survey.outcome is None:
                self._cycle()
            self.link.disarm(DISARM_TIMEOUT)
        except LinkLost as error:
            self.journal.event(RIG_LOST, self.rig.now(), {"text": str(error)})
            survey.outcome = survey.outcome or Outcome(RunStatus.LINK_LOST, str(error))
        except SafetyStop as error:
            survey.outcome = survey.outcome or Outcome(RunStatus.SAFETY_STOP, str(error))
        self._record_notes()

    def judge(self) -> dict[str, Any] | None:
        """What the rig's referee saw; None when the rig is gone. Zones go to it as they were, version by version."""
        zones = [
            {"t": zone.since, "until": zone.until, "id": zone.id, "x": zone.x, "y": zone.y, "r": zone.radius}
            for zone in self.survey.perception.keepout.history
        ]
        detections = [
            {"id": place.id, "class": place.kind, "x": place.x, "y": place.y}
            for place in self.survey.perception.indications
        ]
        self.journal.event(VERDICT_ASKED, self.rig.now(), {"zones": zones, "detections": detections})
        try:
            return self.rig.finish(zones, detections)
        except LinkLost:
            return None

    def _cycle(self) -> None:
        now = self.rig.next_cycle(CYCLE)
        self.rig.advance(now)
        telemetry = self.link.poll()
        frames = list(self.rig.frames)
        for event in telemetry:
            self.journal.telemetry(now, event)
        for frame in frames:
            self.journal.frame(now, frame)
        self._obey_operator()
        orders = self.survey.step(now, telemetry, frames, self.link.state)
        self._carry_out(orders)
        self._record(now, bool(frames))
        trouble = self._keep(now)
        if trouble is not None:
            self.survey.abort(Outcome(RunStatus.PARTIAL, trouble))
        if self._on_status is not None and now >= self._status_due:
            self._status_due = now + STATUS_PERIOD
            self._on_status(self._status(now))

    def _carry_out(self, orders: Orders) -> None:
        if orders.stop:
            self.link.stop()
        if orders.arm:
            try:
                self.link.arm()
            except PreflightFailed as error:
                self.survey.outcome = Outcome(RunStatus.SAFETY_STOP, str(error))
        if orders.segments:
            content = {"start": orders.start, "segments": [asdict(segment) for segment in orders.segments]}
            self.journal.event(SEGMENTS, self.rig.now(), content)
        if orders.segments and orders.start is not None:
            self.link.stream.begin(orders.segments, orders.start)
        elif orders.segments:
            self.link.stream.extend(orders.segments)

    def _obey_operator(self) -> None:
        wanted = (self._control.stop, self._control.emergency)
        if wanted != self._obeyed:
            self._obeyed = wanted
            self.journal.event(OPERATOR, self.rig.now(), {"stop": wanted[0], "emergency": wanted[1]})
        if self._control.emergency:
            self.link.emergency_stop()
            self.survey.outcome = Outcome(RunStatus.ABORTED, "emergency stop by the operator")
        elif self._control.stop:
            self.survey.abort(Outcome(RunStatus.ABORTED, "ended by the operator"))

    def _record(self, now: float, seen: bool) -> None:
        survey = self.survey
        perception = survey.perception
        self.track.add(now, perception.pose, perception.localizer.odometry_only, perception.sigma)
        if seen:
            self.journal.pose(now, perception.pose)
            if perception.last_fix is not None:
                self.journal.event(FIX, now, perception.last_fix)
            self._record_places(now)
        if survey.decisions != self._decisions and survey.decision is not None:
            self._decisions = survey.decisions
            self.journal.path(now, survey.decision.path)
        self._record_notes()

    def _record_places(self, now: float) -> None:
        """Suspected places whenever one of them has changed."""
        places = [
            {"id": p.id, "class": p.kind, "p": p.mine_probability, "x": p.x, "y": p.y, "sigma_m": p.sigma_m}
            for p in self.survey.perception.suspected
        ]
        if places != self._places:
            self._places = places
            self.journal.event(PLACES, now, {"places": places})

    def _record_notes(self) -> None:
        for at, text in self.survey.timeline[self._noted :]:
            self.journal.log(at, "info", text)
        self._noted = len(self.survey.timeline)

    def _status(self, now: float) -> Status:
        survey, perception = self.survey, self.survey.perception
        goals = list(survey.goals)
        figures = self.link.figures()
        return Status(
            time=now,
            phase=survey.phase,
            firmware=self.link.state.state if self.link.state else "?",
            x=perception.pose.x,
            y=perception.pose.y,
            heading=perception.pose.heading,
            sigma=perception.sigma,
            goals_done=sum(goal.state is not GoalState.PENDING for goal in goals),
            goals=len(goals),
            indications=len(perception.indications),
            surveyed=survey.coverage.surveyed_share(),
            battery=perception.battery.voltage if perception.battery else None,
            lost_frames=figures.lost + figures.firmware_lost,
            round_trip=figures.round_trip_median,
            wall=time.monotonic() - self._begin,
        )
