"""The mission itself: what has come in goes in, what is to be sent comes out. No I/O, no clock, no chance of its own.

    look around → decide → drive → (inspect) → decide → … → finished
                           ↳ the place is not known → seek → decide           ↳ home → finished
         ↰ nowhere to go, or a stand-still (`progress`)

`step` is called every cycle with the telemetry and the frames since the last one; the caller carries out its orders.
What leads from phase to phase is the table in `phase`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.detection.second_look import sign_at
from rover.geometry import wrap_angle
from rover.link.telemetry import Battery, FirmwareState, Telemetry
from rover.link.words import MotorState
from rover.mission.caution import BOLD, CAUTIOUS, SURER, Caution
from rover.mission.checks import Checks
from rover.mission.choice import choose
from rover.mission.conclusion import Conclusion, Ending
from rover.mission.config import Mission
from rover.mission.contacts import Contacts
from rover.mission.coverage import Coverage
from rover.mission.drive import Drive
from rover.mission.earlier_visit import EarlierVisit, Fused
from rover.mission.ending import judged, percent
from rover.mission.energy import Gauge, way_back_s
from rover.mission.fault_desk import FaultDesk
from rover.mission.freespace import FreeSpace, Mask, free_space
from rover.mission.goals import Goal, Goals, GoalState, judge_inspection
from rover.mission.halting import halt, recover
from rover.mission.holds import Holds
from rover.mission.home import WayHome
from rover.mission.kept_space import KeptSpace
from rover.mission.orders import Orders
from rover.mission.perception import Perception
from rover.mission.phase import Event, Phase, transition
from rover.mission.progress import Duty, Odometer, Progress
from rover.mission.stops import Stops
from rover.mission.targets import MIN_GAIN, START_ESCAPE, Decision, Target, tour_planner
from rover.mission.vigilance import heed, heed_faults, heed_gap
from rover.mission.waiting import waiting_for
from rover.mission.watch import Watch
from rover.outcome import Outcome
from rover.vehicle import Vehicle

# Steps of the first look around: the camera sees 57° at a time, and four quarter turns show their ends twice.
LOOK_TURNS = 4
# Steps of a look around for ground that the rover knows: one whole turn.
SEEK_TURNS = 6
# Seconds that an inspection looks: eight frames.
INSPECTION_TIME_S = 1.0
# Seconds that the mission waits for the bias of a gyroscope before it sets off.
SETTLING_S = 3.0
# Seconds of looking after each step of a seek: pictures of a turning camera fit less often than those of one at rest.
SEEK_PAUSE_S = 0.5


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
        self.drive = Drive(vehicle, mission.rover.cruise_speed, perception.speed_limit)
        self.phase = Phase.START
        self.outcome: Outcome | None = None
        self.decision: Decision | None = None
        self.decisions = 0
        # No more is known to see or to inspect.
        self.exhausted = False
        self.timeline: list[tuple[float, str]] = []
        self.gauge = Gauge(vehicle.pack)
        # A person is there who is asked before power returns after a gap.
        self.attended = False
        self.since = 0.0  # when the present phase began, seconds
        self._turns_left = LOOK_TURNS
        self._target: Target | None = None
        self.conclusion = Conclusion(WayHome(mission.launch.pose, seed), mission.return_home)
        self.holds = Holds()
        self._braked_for: Ending | None = None
        self.watch = Watch(mission.max_duration_s)
        self.stops = Stops(float(self.coverage.wanted.sum()) * perception.grid.resolution**2)
        # A survey of this field at another hour, and what both say together once this one is over.
        self.earlier: EarlierVisit | None = None
        self.fused: Fused | None = None
        self.checks = Checks()
        self._desk = FaultDesk()
        self.odometer = Odometer(vehicle)
        self._space = KeptSpace(perception.grid, mission.launch, vehicle)
        self._planner = tour_planner(self._space.radius, seed)
        self._progress = Progress()

    def abort(self, outcome: Outcome, home: bool = False) -> None:
        """Brings the rover to rest and ends the mission so; with `home` it drives back first, if it may."""
        if self.outcome is None:
            self.conclusion.ask(outcome, home)

    def hold(self, now: float, name: str, line: str, until: float = math.inf) -> None:
        """Brings the rover to rest, until `holds.release(name)` or, at the time `until`, the mission's end."""
        if self.holds.add(name, line, until):
            self.note(now, line)
            self.drive.stop()

    def turn_away_from(self, goal: Goal) -> None:
        """Gives up a drive to that goal."""
        if self.phase is Phase.DRIVE and self._target is not None and self._target.goal is goal:
            self.drive.blocked = True
            self.drive.stop()

    def way_back_s(self) -> float:
        """About how long the way back to the launch takes, seconds; 0 there."""
        way, pose = self.conclusion.way, self.perception.pose
        return 0.0 if way.reached(pose) else way_back_s(way.straight_m(pose), self.mission.rover.cruise_speed)

    # -- one cycle -----------------------------------------------------------------------------------------------

    def step(
        self, now: float, telemetry: Sequence[Telemetry], frames: Sequence[Frame], firmware: FirmwareState | None
    ) -> Orders:
        """Takes in what has come and says what is to be done."""
        mapped = self._take(now, telemetry, frames)
        if self.outcome is not None:
            return Orders()
        heed_gap(self, now)
        if firmware is not None:
            heed_faults(self, self._desk, now, telemetry, frames, firmware)
        orders = self._advance(now, mapped, firmware)
        self._heed_progress(now)
        return orders

    def _advance(self, now: float, mapped: bool, firmware: FirmwareState | None) -> Orders:
        if firmware is None:
            return Orders()
        if self.phase is Phase.START:
            if self.conclusion.end is not None:  # nobody is armed who has been told to stop
                self.conclude(now)
                return Orders()
            if self.perception.inertial.settling and self.watch.lasted(now) < SETTLING_S:
                return Orders()
            self.happen(Event.CONNECTED, now)
            return Orders(arm=True)
        stopped = firmware.state in (MotorState.STOPPING, MotorState.LATCHED, MotorState.DISARMED)
        if stopped and transition(self.phase, Event.STOPPED):
            halt(self, now, firmware)
        if self.phase is Phase.HALTED:
            return recover(self, now, firmware)
        self.heed(now)
        space = self._free_space() if mapped else None
        if space is not None and not self.drive.at_rest(now):
            near = space.around(np.vstack([self.drive.path, [(self.perception.pose.x, self.perception.pose.y)]]))
            careful = self.caution.keep_off(near, self._kept_off + SURER, self.perception.pose)
            if self.drive.check(careful, self.perception.pose, near):
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
            if isinstance(event, Battery):
                self.gauge.take(event)
        self.odometer.take(telemetry)
        self.watch.take(now, frames)
        mapped = False
        for frame in frames:
            mapped = self.perception.see(frame, now) or mapped
            shift = self.perception.shift()
            if shift is not None:
                self.drive.move(shift)
                self._target = self._target and self._target.moved(shift)
        self.caution.drive(self.perception.pose, self.vehicle)
        if mapped:
            self.goals.update(self.perception.suspected)
            self.caution.look(self.perception.pose)
        return mapped

    def _free_space(self, seen: Mask | None = None) -> FreeSpace:
        """`seen`: ground to count as seen; what frames have shown when left out."""
        grid = self.perception.grid
        if seen is None:
            area = self.contacts.added_to(self.mission.area)
            return self._space.now(self.perception.zones, area, self.perception.sigma)
        return free_space(
            grid.occupied,
            seen,
            grid.resolution,
            self.perception.zones,
            self.contacts.added_to(self.mission.area),
            self.mission.launch,
            self.vehicle,
        )

    def heed(self, now: float) -> None:
        """What is heeded whatever the rover is about."""
        heed(self, now)
        end = self.conclusion.end
        if end != self._braked_for:
            self._braked_for = end
            self.drive.stop()

    def _heed_progress(self, now: float) -> None:
        """Nothing lasts for ever: the rover turns to see more, or the mission ends."""
        if self.outcome is not None:
            return
        if self.holds and self.phase in (Phase.PAUSED, Phase.HALTED):  # a hold has a limit of its own
            self._progress.decided(now)
        can_turn = transition(self.phase, Event.STALLED) is not None and self.drive.at_rest(now)
        duty = self._progress.check(now, self.odometer.travel, can_turn and not self.watch.blind)
        if duty is Duty.LOOK:
            self.note(now, f"the rover stands still: {self._waiting_for()}; it looks around")
            self._look_around(now)
        elif duty is Duty.END:
            self.conclusion.stay(self._progress.reason(self._waiting_for()))
            self.conclude(now)

    def _look_around(self, now: float) -> None:
        self._turns_left = SEEK_TURNS if self.phase is Phase.SEEK else LOOK_TURNS
        self._progress.looks_around(now)
        self.happen(Event.STALLED, now)

    def _waiting_for(self) -> str:
        perception = self.perception
        return waiting_for(self.phase, self.watch.blind, perception.placed, perception.relative_sigma, self.stops.last)

    # -- at rest -------------------------------------------------------------------------------------------------

    def _at_rest(self, now: float, space: FreeSpace | None) -> None:
        """The rover stands and nothing is committed: the next thing to do, by phase."""
        end = self.conclusion.end
        if end is not None and end.stay:
            self.conclude(now)
        elif self.holds and end is not None:  # who has told it to stand is not surprised by a rover that drives home
            self.conclusion.stay(self.holds.line)
        elif self.holds or self.phase is Phase.PAUSED:
            self.happen(Event.PAUSE if self.holds else Event.GO, now)
        else:
            self._next(now, space, end.outcome if end is not None else None)

    def _next(self, now: float, space: FreeSpace | None, outcome: Outcome | None) -> None:
        """`outcome`: of a mission that is to end at home."""
        if self.watch.astray:
            self.watch.astray, self._turns_left = False, SEEK_TURNS
            self.happen(Event.ASTRAY, now)
        if self.watch.blind and transition(self.phase, Event.BLIND):
            self.happen(Event.BLIND, now)
        elif self.phase is Phase.LOOK and self._turns_left == 0:
            self.happen(Event.LOOKED, now)
        elif self.phase is Phase.LOOK:
            self._turn_on(LOOK_TURNS)
        elif self.phase is Phase.SEEK:
            self._seek(now)
        elif outcome is not None:
            self._go_home(now, space, outcome)
        elif self.phase is Phase.DRIVE:
            self._arrive(now)
        elif self.phase is Phase.INSPECT and self._target is not None and self._target.goal is not None:
            if now - self.since >= INSPECTION_TIME_S:
                self._inspected(now, self._target.goal)
        elif self.phase is Phase.DECIDE and space is not None:
            self._decide(now, space)

    def _turn_on(self, steps: int) -> None:
        """One step of a whole turn in so many."""
        self._turns_left -= 1
        pose = self.perception.pose
        self.drive.turn(pose, wrap_angle(pose.heading + 2.0 * math.pi / steps))

    def _seek(self, now: float) -> None:
        sigma = self.perception.relative_sigma
        if self.perception.placed:
            self.note(now, f"the place is known again (1σ of {sigma:.2f} m)")
            self.happen(Event.PLACED, now)
        elif now - max(self.since, self.drive.committed.end_time) >= SEEK_PAUSE_S:
            if self._turns_left == 0:
                where = f"the rover does not know where it is (1σ of {sigma:.2f} m)"
                self.conclusion.stay(f"{where} and looked all around in vain")
            else:
                self._turn_on(SEEK_TURNS)

    def _go_home(self, now: float, space: FreeSpace | None, outcome: Outcome) -> None:
        """The mission will end: at the launch, or here if no way leads there."""
        pose, way = self.perception.pose, self.conclusion.way
        if way.reached(pose):
            self.conclude(now)
        elif way.given_up:
            self.conclusion.stay(f"the way back was blocked {way.ways} times")
        elif way.wants_look():
            self.note(now, "the way back was blocked again: it looks around")
            self._look_around(now)
        elif space is not None:
            for self._kept_off in (CAUTIOUS, BOLD):
                careful = self.caution.keep_off(space, self._kept_off, pose)
                path = way.path(careful, pose)
                if path is not None:
                    self._set_out(careful, path, None)
                    self.note(now, f"{outcome.reason}; it drives home")
                    self.happen(Event.RETURN, now)
                    return
            if self._progress.looked:
                self.conclusion.stay("no way back over free ground that has been seen")
            else:
                self._look_around(now)

    def _set_out(self, space: FreeSpace, path: NDArray[np.float64], heading: float | None) -> None:
        clear = space.is_clear(np.vstack([path[:1], path[:1]]))
        self.drive.start(path, heading, 0.0 if clear else START_ESCAPE, space)

    def _decide(self, now: float, space: FreeSpace) -> None:
        pose, pending = self.perception.pose, self.goals.pending
        self.decisions += 1
        standoff = self.mission.detector.standoff
        unseen, footprint = self.coverage.unseen(), self.perception.footprint
        choice = choose(space, self.caution, pose, pending, unseen, footprint, standoff, self._planner)
        self.decision, self._kept_off = choice.decision, choice.kept_off
        if self.decision is None:
            self._decide_to_end(now)
            return
        target = self._target = self.decision.target
        self._set_out(choice.space, self.decision.path, target.pose.heading)
        self._progress.drives(now, self.coverage.gain_units(MIN_GAIN) + self.goals.settled)
        self.note(now, _purpose(target))
        self.happen(Event.SET_OUT, now)

    def _decide_to_end(self, now: float) -> None:
        """There is nowhere to go: what was seen from one heading alone is no reason to end yet."""
        pending, share = self.goals.pending, self.own_coverage()
        if not self._progress.looked and (pending or share < self.mission.required_coverage):
            self.note(now, f"nowhere to go, {percent(share)} seen and {len(pending)} goals open: it looks around")
            self._look_around(now)
            return
        for goal in pending:
            goal.state = GoalState.UNREACHABLE
            goal.reason = "no way to any pose that shows it over surveyed, free ground"
        self.exhausted = True
        self.abort(judged(share, self.mission.required_coverage, list(self.goals)), home=True)

    def own_coverage(self) -> float:
        """Share shown of the ground that could be seen, 0 to 1, by the rover's own map."""
        reach = float(np.linalg.norm(self.perception.footprint, axis=1).max())
        starts = (self.mission.launch.pose, self.perception.pose)
        return self.coverage.share(self._free_space(np.ones_like(self.perception.grid.seen)), starts, reach)

    def _arrive(self, now: float) -> None:
        assert self._target is not None
        if self.drive.blocked:
            self.note(now, f"{self.drive.why}: planning anew")
            self.happen(Event.BLOCKED, now)
        elif self._target.goal is not None:
            self.perception.count_views(self._target.goal)
            self.happen(Event.ARRIVED, now)
        else:
            self.coverage.look(self.perception.in_view(self._target.pose))
            self.happen(Event.SHOWN, now)

    def _inspected(self, now: float, goal: Goal) -> None:
        told = judge_inspection(goal, self.perception.was_viewed(goal), now)
        if told is not None:
            self.note(now, told)
        if goal.state is GoalState.INSPECTED and goal.place_id is not None:
            self.perception.released.add(goal.place_id)
        self.happen(Event.INSPECTED, now)

    # -- bookkeeping ---------------------------------------------------------------------------------------------

    def happen(self, event: Event, now: float) -> None:
        """The table of phases decides what comes of it."""
        phase = transition(self.phase, event)
        if phase is not None:
            if phase is not self.phase:
                self._progress.decided(now)
            self.phase, self.since = phase, now

    def conclude(self, now: float) -> None:
        """The mission ends where the rover stands."""
        self.outcome = self.conclusion.settle(self.perception.pose)
        self.note(now, f"{self.outcome.status}: {self.outcome.reason}")
        self.happen(Event.ENDED, now)

    def note(self, now: float, text: str) -> None:
        """A line of the timeline."""
        self.timeline.append((now, text))


def _purpose(target: Target) -> str:
    return f"to inspect {target.goal.id}" if target.goal else f"to see {target.gain_m2:.2f} m² of unseen ground"
