"""The loop of a mission: what the rig hands over goes into the survey, what the survey orders goes out over the link.

Everything that enters the survey enters through `_cycle` and is written down there; everything that it decides, too.
A replay runs this same loop over a recorded rig, with a journal that compares.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from rover.capture.frame import Frame
from rover.detection.place import Anchor
from rover.errors import BadInput, LinkLost, PreflightFailed, SafetyStop
from rover.link.firmware_document import firmware_document, in_words
from rover.link.rig import Rig
from rover.link.session import Link
from rover.link.watching import Moment as Measured
from rover.link.watching import with_event
from rover.mission.commands import Command, Word
from rover.mission.ear import Ear
from rover.mission.earlier_visit import fuse
from rover.mission.goals import GoalState
from rover.mission.moment import moment_of
from rover.mission.operator import remaining_s, situation, tell
from rover.mission.orders import Orders
from rover.mission.survey import Survey
from rover.mission.track import Track
from rover.outcome import Outcome, RunStatus
from rover.record.journal import Journal
from rover.record.topics import FIX, OPERATOR, PLACES, RIG_LOST, SEGMENTS, VERDICT_ASKED

CYCLE = 0.02
STATUS_PERIOD = 0.5
# Seconds between two notes of where the rover believes to be among the things around it.
LOOK_PERIOD = 0.5
# Seconds between two maps in the log; the last one is that of the mission's end.
GRID_PERIOD = 30.0
# After the mission's end the rover is disarmed; this long the link may take to confirm it.
DISARM_TIMEOUT = 2.0


@dataclass
class Control:
    """What the operator wants, set from signal handlers and polled by the loop."""

    stop: bool = False
    emergency: bool = False
    # A person is there who is asked before power returns after a gap.
    attended: bool = False
    # What was said and has not been heard yet, oldest first.
    commands: deque[Command] = field(default_factory=deque)


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
    # Seconds that the mission may still take, and watt hours and seconds until the battery is too low to drive.
    remaining: float | None = None
    energy_wh: float | None = None
    energy_s: float | None = None
    # What keeps the rover standing until somebody decides.
    waits_for: str = ""


def _anchored(anchor: Anchor | None) -> dict[str, Any]:
    """From where something was seen: time, and the rover's pose as the map has it."""
    if anchor is None:
        return {}
    x, y, heading = anchor.pose.x, anchor.pose.y, anchor.pose.heading
    return {"anchor": {"t": anchor.time, "x": x, "y": y, "heading": heading}}


class MissionLoop:
    """The loop of one mission over one link."""

    def __init__(
        self,
        survey: Survey,
        rig: Rig,
        journal: Journal,
        on_status: Callable[[Status], None] | None,
        control: Control,
        session: int,
        keep: Callable[[float], str | None] = lambda now: None,
        ear: Ear | None = None,
    ) -> None:
        """`session`: 16-bit number that the firmware is to know this mission by.

        `keep`: called every cycle to keep what has been learned; says why it can't, which ends the mission.
        `ear`: what is asked and said over a socket.
        """
        self.survey = survey
        self.rig = rig
        self.track = Track()
        self.journal = journal
        self.link = Link(rig.transport, rig, session=session, tap=journal.link)
        self._on_status = on_status
        self._control = control
        self._keep = keep
        self._ear = ear
        self._status_due = 0.0
        self._look_due = 0.0
        self._grid_due = GRID_PERIOD
        self._begin = time.monotonic()
        self._noted = 0
        self._decisions = 0
        self._obeyed = (False, False, False)
        self._frame: Frame | None = None
        # For `rover monitor`: the survey knows nothing of it.
        self._measured = Measured(0.0)
        self._places: list[dict[str, Any]] = []

    def drive(self) -> None:
        """From the handshake to the survey's outcome; a lost link or a restarted firmware is an outcome too."""
        survey = self.survey
        self.link.connect()
        try:
            while survey.outcome is None:
                self._cycle()
            confirmed = self.link.disarm(DISARM_TIMEOUT)
            if self._control.emergency:
                survey.outcome = Outcome(
                    survey.outcome.status, f"{survey.outcome.reason}; {self._true_state(confirmed)}"
                )
        except LinkLost as error:
            self.journal.event(RIG_LOST, self.rig.now(), {"text": str(error)})
            survey.outcome = survey.outcome or Outcome(RunStatus.LINK_LOST, str(error))
        except SafetyStop as error:
            survey.outcome = survey.outcome or Outcome(RunStatus.SAFETY_STOP, str(error))
        if survey.earlier is not None:
            hour = survey.mission.time_of_day_s / 3600.0
            survey.fused = fuse(survey.earlier, survey.perception, hour, self.rig.now())
        self._record_notes()

    def _true_state(self, confirmed: bool) -> str:
        """What is known of the motors after an emergency stop: only what the firmware has said counts."""
        state = self.link.state
        if not confirmed or state is None or state.powered:
            return "the firmware has not confirmed that the motors are off: look at the rover"
        return f"the motors are off, the firmware is {in_words(state)}"

    def judge(self) -> dict[str, Any] | None:
        """What the rig's referee saw; None when the rig is gone. Zones go to it as they were, version by version."""
        zones = [
            {
                "t": zone.since,
                "until": zone.until,
                "id": zone.id,
                "x": zone.x,
                "y": zone.y,
                "r": zone.radius,
                **_anchored(zone.anchor),
            }
            for zone in self.survey.perception.keepout.history
        ]
        detections = [
            {"id": place.id, "class": place.kind, "x": place.x, "y": place.y, **_anchored(place.anchor)}
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
            self._measured = with_event(self._measured, event)
        for frame in frames:
            self.journal.frame(now, frame)
        self._obey_operator()
        self.survey.checks.clock(self.link.clock_estimate.error_bound)
        orders = self.survey.step(now, telemetry, frames, self.link.state)
        self._carry_out(orders)
        self._record(now, bool(frames))
        self.survey.checks.kept(self._keep(now))
        if self._on_status is not None and now >= self._status_due:
            self._status_due = now + STATUS_PERIOD
            self._on_status(self._status(now))
        self._frame = frames[-1] if frames else self._frame
        self._show(now)

    def _show(self, now: float) -> None:
        """To those who look on, if there are any and it is time: what they are told changes nothing here."""
        if self._ear is None or not self._ear.watchers.due():
            return
        told = {"mission": self._told(), "status": asdict(self._status(now)), "firmware": self._firmware()}
        moment = moment_of(self.survey, told, self.track, self._frame, self._ear.watchers.map_due())
        self._ear.watchers.show(moment)

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
        control = self._control
        while control.commands:
            self._obey(control.commands.popleft())
        answers = [
            (each, self._answer(each.content)) for each in (self._ear.waiting() if self._ear is not None else ())
        ]
        wanted = (control.stop, control.emergency, control.attended)
        if wanted != self._obeyed:
            self._obeyed = wanted
            content = {"stop": wanted[0], "emergency": wanted[1], "attended": wanted[2]}
            self.journal.event(OPERATOR, self.rig.now(), content)
        self.survey.attended = control.attended
        if self._control.emergency:
            self.link.emergency_stop()
            self.survey.outcome = Outcome(RunStatus.ABORTED, "emergency stop by the operator")
        elif self._control.stop:
            self.survey.abort(Outcome(RunStatus.ABORTED, "ended by the operator"))
        for request, answer in answers:
            request.reply(answer if not control.emergency else {**answer, "says": situation(self.survey)})

    def _obey(self, command: Command) -> None:
        """Says it to the survey, and notes that it was said: a replay says it in the same cycle. Raises BadInput."""
        tell(self.survey, self.rig.now(), command)
        self.journal.event(OPERATOR, self.rig.now(), {"word": command.word, "goal": command.goal})

    def _answer(self, content: dict[str, Any]) -> dict[str, Any]:
        """To a line that came over the socket."""
        try:
            word, goal = content.get("op"), content.get("id", "")
            if word == Word.EMERGENCY:
                self._control.emergency = True
            elif word in list(Word):
                self._obey(Command(Word(word), goal if isinstance(goal, str) else str(goal)))
            elif word not in ("state", "status"):
                raise BadInput(f"{word}: not known; say {', '.join(('state', 'status', *Word))}")
        except BadInput as error:
            return {"ok": False, "error": str(error)}
        if word == "status":
            measured = replace(self._measured, time_s=self.rig.now()).as_dict()
            return {"ok": True, **self._firmware(), "mission": self._told(), "measured": measured}
        return {"ok": True, **self._told()}

    def _told(self) -> dict[str, Any]:
        """How the mission is doing."""
        survey, status = self.survey, self._status(self.rig.now())
        return {
            "state": survey.phase.value,
            "says": situation(survey),
            "time_s": round(status.time, 2),
            "x": round(status.x, 4),
            "y": round(status.y, 4),
            "surveyed": round(status.surveyed, 4),
            "goals": [goal.id for goal in survey.goals.pending],
            "remaining_s": None if status.remaining is None else round(status.remaining, 1),
            "energy_wh": None if status.energy_wh is None else round(status.energy_wh, 2),
        }

    def _firmware(self) -> dict[str, Any]:
        """What `rover status` would hear, without a word on the wire."""
        link, battery = self.link, self.survey.perception.battery
        if link.identity is None or link.state is None:
            return {}
        return firmware_document(self.rig.transport.port, link.identity, link.state, battery, link.figures())

    def _record(self, now: float, seen: bool) -> None:
        survey = self.survey
        perception = survey.perception
        self.track.add(
            now, perception.pose, perception.localizer.odometry_only, perception.sigma, perception.relative_sigma
        )
        if now >= self._grid_due or survey.outcome is not None:
            self._grid_due = now + GRID_PERIOD
            self.journal.grid(now, perception.grid.seen, perception.grid.occupied, perception.grid.resolution)
        if now >= self._look_due:
            self._look_due = now + LOOK_PERIOD
            found = perception.among_things()
            if found is not None:
                self.track.among_things.append(found)
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
            remaining=remaining_s(survey, now),
            energy_wh=survey.gauge.left_wh,
            energy_s=survey.gauge.left_s,
            waits_for=survey.holds.line,
        )
