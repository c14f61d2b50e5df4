"""The mission itself: what has come in goes in, what is to be sent comes out. No I/O, no clock, no chance of its own.

    look around → decide → drive → (inspect) → decide → … → finished
                           ↳ the place is not known → seek → decide
         ↰ nowhere to go, or a stand-still (`progress`)

`step` is called every cycle with the telemetry and the frames since the last one; the caller carries out its orders.
What leads from phase to phase is the table in `phase`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rover.capture.frame import Frame
from rover.detection.second_look import sign_at
from rover.geometry import wrap_angle
from rover.link.telemetry import FirmwareState, Telemetry
from rover.link.words import MotorState, StopCause
from rover.mission.caution import BOLD, CAUTIOUS, Caution
from rover.mission.config import Mission
from rover.mission.contacts import BACK_OFF_M, BACK_OFF_SPEED, Contacts
from rover.mission.coverage import Coverage
from rover.mission.drive import Drive
from rover.mission.ending import judged, percent
from rover.mission.freespace import FreeSpace, Mask, free_space
from rover.mission.goals import MAX_ATTEMPTS, Goal, Goals, GoalState
from rover.mission.perception import Perception
from rover.mission.phase import Event, Phase, transition
from rover.mission.progress import Duty, Odometer, Progress
from rover.mission.stops import REARM_DELAY_S, Stops
from rover.mission.targets import MIN_GAIN, START_ESCAPE, Decision, Target, candidates, decide
from rover.mission.watch import Watch
from rover.motion.segment import Segment
from rover.outcome import Outcome, RunStatus
from rover.vehicle import Vehicle

# Steps of the first look around: the camera sees 57° at a time, and four quarter turns show their ends twice.
LOOK_TURNS = 4
# Steps of a look around for ground that the rover knows: one whole turn.
SEEK_TURNS = 6
# Seconds that an inspection looks: eight frames.
INSPECTION_TIME_S = 1.0
# Seconds of looking after each step of a seek: pictures of a turning camera fit less often than those of one at rest.
SEEK_PAUSE_S = 0.5


# What a rover in each phase that has stood still for too long is about.
WAITING_FOR = {
    Phase.START: "the firmware does not tell its state",
    Phase.LOOK: "it should look around and does not turn",
    Phase.SEEK: "it looks for ground that it knows and does not turn",
    Phase.DECIDE: "no picture shows ground to decide on",
    Phase.DRIVE: "it should drive and does not move",
    Phase.INSPECT: "it should inspect a goal",
    Phase.HALTED: "the firmware has stopped it and does not let it go on",
}


@dataclass(frozen=True)
class Orders:
    """What the caller has to do now. start: when the run that these segments begin starts. stop: by the firmware."""

    segments: list[Segment] = field(default_factory=list)
    start: float | None = None
    arm: bool = False
    stop: bool = False


class Survey:
    """One mission over one area."""

    def __init__(self, mission: Mission, vehicle: Vehicle, perception: Perception, seed: int) -> None:
        self.mission = mission
        self.vehicle = vehicle
        self.perception = perception
        self.goals = Goals(mission.goals)
        self.coverage = Coverage(perception.grid, mission.area, mission.launch)
        self.caution = Caution(perception.grid, sign_at(mission.time_of_day_s / 3600.0))
        # The least likeness of the weak spots that the stretch being driven keeps off.
        self._kept_off = CAUTIOUS
        self.contacts = Contacts()
        self.drive = Drive(vehicle, mission.rover.cruise_speed)
        self.phase = Phase.START
        self.outcome: Outcome | None = None
        self.decision: Decision | None = None
        self.decisions = 0
        # No more is known to see or to inspect.
        self.exhausted = False
        self.timeline: list[tuple[float, str]] = []
        self._seed = seed
        # When the present phase began, seconds.
        self._since = 0.0
        self._turns_left = LOOK_TURNS
        self._target: Target | None = None
        # How the mission will end once the rover is at rest, and whether it has begun to brake for that.
        self._end: Outcome | None = None
        self._ending = False
        self._watch = Watch(mission.max_duration_s)
        self._stops = Stops()
        self._odometer = Odometer(vehicle)
        self._progress = Progress()

    def abort(self, outcome: Outcome) -> None:
        """Brings the rover to rest and ends the mission with this outcome."""
        if self._end is None and self.outcome is None:
            self._end = outcome

    # -- one cycle -----------------------------------------------------------------------------------------------

    def step(
        self, now: float, telemetry: Sequence[Telemetry], frames: Sequence[Frame], firmware: FirmwareState | None
    ) -> Orders:
        """Takes in what has come and says what is to be done."""
        mapped = self._take(now, telemetry, frames)
        if self.outcome is not None:
            return Orders()
        orders = self._advance(now, mapped, firmware)
        self._heed_progress(now)
        return orders

    def _advance(self, now: float, mapped: bool, firmware: FirmwareState | None) -> Orders:
        if firmware is None:
            return Orders()
        if self.phase is Phase.START:
            if self._end is not None:  # nobody is armed who has been told to stop
                self._finish(now, self._end)
                return Orders()
            self._happen(Event.CONNECTED, now)
            return Orders(arm=True)
        stopped = firmware.state in (MotorState.STOPPING, MotorState.LATCHED, MotorState.DISARMED)
        if stopped and transition(self.phase, Event.STOPPED):
            self._halt(now, firmware)
        if self.phase is Phase.HALTED:
            return self._recover(now, firmware)
        self._heed_watch(now)
        space = self._free_space() if mapped else None
        if space is not None and not self.drive.at_rest(now):
            careful = self.caution.keep_off(space, self._kept_off, self.perception.pose)
            urgent = self.drive.check(careful, self.perception.pose, space)
            if urgent:
                return Orders(stop=True)
        segments, start = self.drive.step(now, self.perception.pose)
        if not segments and self.drive.at_rest(now):
            self._at_rest(now, space)
            segments, start = self.drive.step(now, self.perception.pose)
        return Orders(segments, start)

    def _take(self, now: float, telemetry: Sequence[Telemetry], frames: Sequence[Frame]) -> bool:
        """What has come in; True when the map has changed."""
        for event in telemetry:
            self.perception.take(event)
        self._odometer.take(telemetry)
        self._watch.take(now, frames)
        mapped = False
        for frame in frames:
            mapped = self.perception.see(frame, now) or mapped
        self.caution.drive(self.perception.pose, self.vehicle)
        if mapped:
            self.goals.update(self.perception.suspected)
            self.caution.look(self.perception.pose)
        return mapped

    def _free_space(self, seen: Mask | None = None) -> FreeSpace:
        """`seen`: ground to count as seen; what frames have shown when left out."""
        grid = self.perception.grid
        return free_space(
            grid.occupied,
            grid.seen if seen is None else seen,
            grid.resolution,
            self.perception.keepout.active,
            self.contacts.added_to(self.mission.area),
            self.mission.launch,
            self.vehicle,
        )

    def _heed_watch(self, now: float) -> None:
        """Nobody drives blind, astray or beyond the time: the rover brakes first."""
        lost_place = self.phase is not Phase.SEEK and not self.perception.placed
        concerns = self._watch.check(now, self.perception.relative_sigma, lost_place)
        for note in concerns.notes:
            self._note(now, note)
            self.drive.stop()
        if concerns.end is not None:
            self.abort(concerns.end)
        if self._end is not None and not self._ending:
            self._ending = True
            self.drive.stop()

    def _heed_progress(self, now: float) -> None:
        """Nothing lasts for ever: the rover turns to see more, or the mission ends."""
        if self.outcome is not None:
            return
        can_turn = transition(self.phase, Event.STALLED) is not None and self.drive.at_rest(now)
        duty = self._progress.check(now, self._odometer.travel, can_turn and not self._watch.blind)
        if duty is Duty.LOOK:
            self._note(now, f"the rover stands still: {self._waiting_for()}; it looks around")
            self._look_around(now)
        elif duty is Duty.END:
            self._finish(now, self._end or Outcome(RunStatus.PARTIAL, self._progress.reason(self._waiting_for())))

    def _look_around(self, now: float) -> None:
        self._turns_left = SEEK_TURNS if self.phase is Phase.SEEK else LOOK_TURNS
        self._progress.looks_around(now)
        self._happen(Event.STALLED, now)

    def _waiting_for(self) -> str:
        """What a rover that stands still is about, for the operator."""
        if self.phase is Phase.HALTED:
            return f"{WAITING_FOR[self.phase]} ({self._stops.last})"
        if self.phase is Phase.START:
            return WAITING_FOR[self.phase]
        if self._watch.blind:
            return "the camera shows nothing"
        if not self.perception.placed:
            sigma = self.perception.relative_sigma
            return f"the place is not known well enough to map what the camera shows (1σ of {sigma:.2f} m)"
        return WAITING_FOR[self.phase]

    # -- at rest -------------------------------------------------------------------------------------------------

    def _at_rest(self, now: float, space: FreeSpace | None) -> None:
        """The rover stands and nothing is committed: the next thing to do, by phase."""
        if self._end is not None:
            self._finish(now, self._end)
            return
        if self._watch.astray:
            self._watch.astray, self._turns_left = False, SEEK_TURNS
            self._happen(Event.ASTRAY, now)
        if self._watch.blind and transition(self.phase, Event.BLIND):
            self._happen(Event.BLIND, now)
        elif self.phase is Phase.LOOK:
            self._look(now)
        elif self.phase is Phase.SEEK:
            self._seek(now)
        elif self.phase is Phase.DRIVE:
            self._arrive(now)
        elif self.phase is Phase.INSPECT:
            if now - self._since >= INSPECTION_TIME_S:
                self._inspected(now)
        elif self.phase is Phase.DECIDE and space is not None:
            self._decide(now, space)

    def _look(self, now: float) -> None:
        if self._turns_left == 0:
            self._happen(Event.LOOKED, now)
        else:
            self._turn_on(LOOK_TURNS)

    def _turn_on(self, steps: int) -> None:
        """One step of a whole turn in so many."""
        self._turns_left -= 1
        pose = self.perception.pose
        self.drive.turn(pose, wrap_angle(pose.heading + 2.0 * math.pi / steps))

    def _seek(self, now: float) -> None:
        sigma = self.perception.relative_sigma
        if self.perception.placed:
            self._note(now, f"the place is known again (1σ of {sigma:.2f} m)")
            self._happen(Event.PLACED, now)
        elif now - max(self._since, self.drive.committed.end_time) >= SEEK_PAUSE_S:
            if self._turns_left == 0:
                why = f"the rover does not know where it is (1σ of {sigma:.2f} m) and looked all around in vain"
                self._finish(now, Outcome(RunStatus.PARTIAL, why))
            else:
                self._turn_on(SEEK_TURNS)

    def _decide(self, now: float, space: FreeSpace) -> None:
        pose, pending = self.perception.pose, self.goals.pending
        self.decisions += 1
        standoff, seed = self.mission.detector.standoff, self._seed + self.decisions
        for self._kept_off in (CAUTIOUS, BOLD):
            careful = self.caution.keep_off(space, self._kept_off, pose)
            unseen, footprint = self.coverage.unseen(), self.perception.footprint
            targets = candidates(careful, pose, pending, unseen, footprint, standoff)
            self.decision = decide(careful, pose, targets, seed)
            if self.decision is not None:
                space = careful
                break
        if self.decision is None:
            self._decide_to_end(now)
            return
        target = self._target = self.decision.target
        inside = not space.is_clear(np.vstack([self.decision.path[:1], self.decision.path[:1]]))
        self.drive.start(self.decision.path, target.pose.heading, START_ESCAPE if inside else 0.0, space)
        self._progress.drives(now, self._gain())
        self._note(now, _purpose(target))
        self._happen(Event.SET_OUT, now)

    def _decide_to_end(self, now: float) -> None:
        """There is nowhere to go: what was seen from one heading alone is no reason to end yet."""
        pending, share = self.goals.pending, self.own_coverage()
        if not self._progress.looked and (pending or share < self.mission.required_coverage):
            self._note(now, f"nowhere to go, {percent(share)} seen and {len(pending)} goals open: it looks around")
            self._look_around(now)
            return
        for goal in pending:
            goal.state = GoalState.UNREACHABLE
            goal.reason = "no way to any pose that shows it over surveyed, free ground"
        self.exhausted = True
        self._finish(now, judged(share, self.mission.required_coverage, list(self.goals)))

    def own_coverage(self) -> float:
        """Share shown of the ground that could be seen, 0 to 1, by the rover's own map."""
        reach = float(np.linalg.norm(self.perception.footprint, axis=1).max())
        starts = (self.mission.launch.pose, self.perception.pose)
        return self.coverage.share(self._free_space(np.ones_like(self.perception.grid.seen)), starts, reach)

    def _gain(self) -> int:
        """Grows with the ground that was shown or looked for in vain, and with the goals that are settled."""
        open_m2 = self._area_m2(self.coverage.unseen())
        total_m2 = self.mission.area.width * self.mission.area.height
        settled = sum(goal.state is not GoalState.PENDING for goal in self.goals)
        return int((total_m2 - open_m2) / MIN_GAIN) + settled

    def _area_m2(self, mask: Mask) -> float:
        return float(mask.sum()) * self.perception.grid.resolution**2

    def _arrive(self, now: float) -> None:
        assert self._target is not None
        if self.drive.blocked:
            self._note(now, "the way ahead is no longer free: planning anew")
            self._happen(Event.BLOCKED, now)
        elif self._target.goal is not None:
            self.perception.count_views(self._target.goal)
            self._happen(Event.ARRIVED, now)
        else:
            self.coverage.look(self.perception.in_view(self._target.pose))
            self._happen(Event.SHOWN, now)

    def _inspected(self, now: float) -> None:
        assert self._target is not None
        assert self._target.goal is not None
        goal = self._target.goal
        goal.attempts += 1
        if goal.state is GoalState.PENDING:
            self._judge_inspection(now, goal)
        self._happen(Event.INSPECTED, now)

    def _judge_inspection(self, now: float, goal: Goal) -> None:
        if self.perception.was_viewed(goal):
            goal.state, goal.inspected_at = GoalState.INSPECTED, now
            if goal.place_id is not None:
                self.perception.released.add(goal.place_id)
            self._note(now, f"{goal.id} inspected")
        elif goal.attempts >= MAX_ATTEMPTS:
            goal.state, goal.reason = GoalState.UNREACHABLE, f"not in view from {goal.attempts} inspection poses"
            self._note(now, f"{goal.id} given up: {goal.reason}")

    # -- stops by the firmware -----------------------------------------------------------------------------------

    def _halt(self, now: float, firmware: FirmwareState) -> None:
        self.drive.halted(now)
        self._stops.add(firmware.cause)
        self._note(now, f"the firmware stopped the rover: {firmware.cause}")
        if firmware.cause == StopCause.BUMPER:
            self.contacts.touch(self.perception.pose, self.vehicle)
        self._happen(Event.STOPPED, now)

    def _recover(self, now: float, firmware: FirmwareState) -> Orders:
        if firmware.state in (MotorState.ARMED, MotorState.MOVING):
            self._happen(Event.REARMED, now)
            if self._stops.last == StopCause.BUMPER:
                self.drive.back_off(BACK_OFF_M, BACK_OFF_SPEED)
        elif firmware.state == MotorState.STOPPING or now - self._since < REARM_DELAY_S:
            pass
        elif self._end is not None:
            self._finish(now, self._end)
        elif self._stops.too_many(firmware.cause):
            self._finish(now, self._stops.outcome(firmware.cause))
        else:
            self._since = now
            return Orders(arm=True)
        return Orders()

    # -- bookkeeping ---------------------------------------------------------------------------------------------

    def _happen(self, event: Event, now: float) -> None:
        phase = transition(self.phase, event)
        if phase is not None:
            if phase is not self.phase:
                self._progress.decided(now)
            self.phase, self._since = phase, now

    def _finish(self, now: float, outcome: Outcome) -> None:
        self.outcome = outcome
        self._note(now, f"{outcome.status}: {outcome.reason}")
        self._happen(Event.ENDED, now)

    def _note(self, now: float, text: str) -> None:
        self.timeline.append((now, text))


def _purpose(target: Target) -> str:
    return f"to inspect {target.goal.id}" if target.goal else f"to see {target.gain_m2:.2f} m² of unseen ground"
