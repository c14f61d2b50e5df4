"""The mission itself: what has come in goes in, what is to be sent comes out. No I/O, no clock, no chance of its own.

    look around → decide → drive → (inspect) → decide → … → finished
                           ↳ the place is not known → seek → decide

`step` is called every cycle with the telemetry and the frames since the last one; the caller carries out its orders.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rover.capture.frame import Frame
from rover.geometry import Pose2, wrap_angle
from rover.link.telemetry import FirmwareState, Telemetry
from rover.mission.config import Mission
from rover.mission.drive import Drive
from rover.mission.freespace import FreeSpace, disc_mask, free_space
from rover.mission.goals import INSPECTED, MAX_ATTEMPTS, PENDING, UNREACHABLE, Goals
from rover.mission.perception import Perception
from rover.mission.sight import BLIND_AFTER, Sight
from rover.mission.targets import START_ESCAPE, Decision, Target, candidates, decide
from rover.motion.segment import Segment
from rover.vehicle import Vehicle

# The first look: the camera sees 57° at a time, so quarter turns with their ends seen twice.
LOOK_TURNS = 4
# How long an inspection looks: eight frames.
INSPECTION_TIME = 1.0
# A cell that stayed unseen from so many viewpoints that should have shown it is hidden.
MAX_LOOKS = 2
# Stops by the firmware that the mission goes on after; the stall of a wheel is tried less often.
REARM_LIMITS = {"SonarGuard": 30, "StopCommand": 100, "Underrun": 5, "DeadMan": 3, "Stall": 3}
# Between the latch and the new arming: the rover has come to rest and the pose has settled.
REARM_DELAY = 0.4
# Steps of a look around for ground that the rover knows: one whole turn.
SEEK_TURNS = 6
# How long it looks after each step: pictures of a turning camera fit less often than those of one at rest.
SEEK_PAUSE = 0.5


@dataclass(frozen=True)
class Orders:
    """What the caller has to do now. start: when the run that these segments begin starts. stop: by the firmware."""

    segments: list[Segment] = field(default_factory=list)
    start: float | None = None
    arm: bool = False
    stop: bool = False


@dataclass(frozen=True)
class Outcome:
    """How a mission ended: a status of the contract, and one sentence that says why."""

    status: str
    reason: str


class Survey:
    """One mission over one area."""

    def __init__(self, mission: Mission, vehicle: Vehicle, perception: Perception, seed: int) -> None:
        self.mission = mission
        self.vehicle = vehicle
        self.perception = perception
        self.goals = Goals(mission.goals)
        self.drive = Drive(vehicle, mission.rover.cruise_speed)
        self.phase = "start"
        self.outcome: Outcome | None = None
        self.decision: Decision | None = None
        self.decisions = 0
        self.replans = 0
        self.timeline: list[tuple[float, str]] = []
        self.stops: dict[str, int] = {}
        self._seed = seed
        self._since = 0.0
        self._started: float | None = None
        self._turns_left = LOOK_TURNS
        self._astray = False
        self._target: Target | None = None
        self._abort: Outcome | None = None
        self._ending = False
        self._sight = Sight()
        self._blind = False
        self.looks = np.zeros(perception.grid.shape, np.uint8)
        self._armed_once = False

    # -- what others may ask -------------------------------------------------------------------------------------

    def abort(self, outcome: Outcome) -> None:
        """Brings the rover to rest and ends the mission with this outcome."""
        if self._abort is None and self.outcome is None:
            self._abort = outcome

    def restore_looks(self, looks: np.ndarray) -> None:
        """Takes over how often each cell was looked for. Raises ValueError when it does not fit."""
        if looks.shape != self.looks.shape:
            raise ValueError("looks do not fit")
        self.looks[:] = looks

    def unseen(self) -> np.ndarray:
        """Cells of the area that no frame has shown and that are worth looking at, (rows, columns)."""
        return self.unshown() & (self.looks < MAX_LOOKS)

    def hidden(self) -> np.ndarray:
        """Cells that stayed unseen though the rover looked."""
        return self.unshown() & (self.looks >= MAX_LOOKS)

    def unshown(self) -> np.ndarray:
        grid = self.perception.grid
        unshown = ~grid.seen & ~grid.occupied
        for x, y, r in self.mission.area.obstacles:
            unshown &= ~disc_mask(grid.shape, grid.resolution, x, y, r)
        launch = self.mission.launch
        return unshown & ~disc_mask(grid.shape, grid.resolution, launch.pose.x, launch.pose.y, launch.surveyed_radius)

    # -- one cycle -----------------------------------------------------------------------------------------------

    def step(
        self, now: float, telemetry: Sequence[Telemetry], frames: Sequence[Frame], firmware: FirmwareState | None
    ) -> Orders:
        """Takes in what has come and says what is to be done."""
        if self._started is None:
            self._started = now
        for event in telemetry:
            self.perception.take(event)
        self._sight.take(now, frames)
        mapped = False
        for frame in frames:
            mapped = self.perception.see(frame, now) or mapped
        if mapped:
            self.goals.update(self.perception.suspected)
        if self.outcome is not None or firmware is None:
            return Orders()
        if self.phase == "start":
            self._enter("look", now)
            return Orders(arm=True)
        if firmware.state in ("Stopping", "Latched", "Disarmed") and self.phase != "halted":
            self._halt(now, firmware)
        if self.phase == "halted":
            return self._recover(now, firmware)
        self._watch_limits(now)
        space = self._free_space() if mapped else None
        if space is not None and not self.drive.at_rest(now):
            urgent = self.drive.check(space, self.perception.pose)
            if urgent:
                return Orders(stop=True)
        segments, start = self.drive.step(now, self.perception.pose)
        if not segments and self.drive.at_rest(now):
            self._at_rest(now, space)
            segments, start = self.drive.step(now, self.perception.pose)
        return Orders(segments, start)

    def _free_space(self) -> FreeSpace:
        grid = self.perception.grid
        return free_space(
            grid.occupied,
            grid.seen,
            grid.resolution,
            self.perception.keepout.active,
            self.mission.area,
            self.mission.launch,
            self.vehicle.radius,
        )

    def _watch_limits(self, now: float) -> None:
        assert self._started is not None
        if now - self._started > self.mission.max_duration_s:
            self.abort(Outcome("partial", f"the time limit of {self.mission.max_duration_s:g} s ran out"))
        self._watch_sight(now)
        self._watch_place(now)
        if self._abort is not None and not self._ending:
            self._ending = True
            self.drive.stop()

    def _watch_sight(self, now: float) -> None:
        """Nobody drives with closed eyes: the rover brakes, waits for pictures, and gives up when none come."""
        lost = self._sight.lost(now)
        if lost is not None:
            self.abort(Outcome("partial", lost))
        blind = self._sight.blind(now)
        if blind and not self._blind:
            self._note(now, f"the camera has shown nothing for {BLIND_AFTER:g} s: the rover waits for pictures")
            self.drive.stop()
        self._blind = blind

    def _watch_place(self, now: float) -> None:
        """Nobody drives who does not know where: the rover brakes and looks around for ground that it knows."""
        if self.phase == "seek" or self._astray or not self.perception.astray:
            return
        self._astray = True
        self._note(now, f"the place is not known (1σ of {self.perception.sigma:.2f} m): looking around")
        self.drive.stop()

    def _at_rest(self, now: float, space: FreeSpace | None) -> None:
        """The rover stands and nothing is committed: the next thing to do, by phase."""
        if self._abort is not None:
            self._finish(now, self._abort)
            return
        if self._astray:
            self._astray, self._turns_left = False, SEEK_TURNS
            self._enter("seek", now)
        if self._blind and self.phase == "drive":
            self._enter("decide", now)
        elif self._blind and self.phase in ("look", "inspect", "seek"):
            self._since = now
        elif self.phase == "look":
            self._look(now)
        elif self.phase == "seek":
            self._seek(now)
        elif self.phase == "drive":
            if self.drive.blocked:
                self.replans += 1
                self._note(now, "the way ahead is no longer free: planning anew")
                self._enter("decide", now)
            else:
                self._arrive(now)
        elif self.phase == "inspect":
            if now - self._since >= INSPECTION_TIME:
                self._inspected(now)
        elif self.phase == "decide" and space is not None:
            self._decide(now, space)

    def _look(self, now: float) -> None:
        if self._turns_left == 0:
            self._enter("decide", now)
            return
        self._turn_on(LOOK_TURNS)

    def _turn_on(self, steps: int) -> None:
        """One step of a whole turn in so many."""
        self._turns_left -= 1
        pose = self.perception.pose
        self.drive.turn(pose, wrap_angle(pose.heading + 2.0 * math.pi / steps))

    def _seek(self, now: float) -> None:
        if self.perception.placed:
            self._note(now, f"the place is known again (1σ of {self.perception.sigma:.2f} m)")
            self._enter("decide", now)
        elif now - max(self._since, self.drive.committed.end_time) >= SEEK_PAUSE:
            if self._turns_left == 0:
                sigma = self.perception.sigma
                why = f"the rover does not know where it is (1σ of {sigma:.2f} m) and looked all around in vain"
                self._finish(now, Outcome("partial", why))
                return
            self._turn_on(SEEK_TURNS)

    def _decide(self, now: float, space: FreeSpace) -> None:
        pose = self.perception.pose
        unseen = self.unseen()
        targets = candidates(
            space,
            pose,
            self.goals.pending,
            unseen,
            self.perception.footprint,
            self.mission.detector.standoff,
        )
        self.decisions += 1
        self.decision = decide(space, pose, targets, self._seed + self.decisions)
        if self.decision is None:
            for goal in self.goals.pending:
                goal.state, goal.reason = UNREACHABLE, "no way to any pose that shows it over surveyed, free ground"
            self._finish(now, Outcome("done", "every goal is inspected or unreachable, nothing is left to see"))
            return
        self._target = self.decision.target
        inside = not space.is_clear(np.vstack([self.decision.path[:1], self.decision.path[:1]]))
        self.drive.start(self.decision.path, self._target.pose.heading, START_ESCAPE if inside else 0.0, space)
        goal = self._target.goal
        self._note(now, f"to inspect {goal.id}" if goal else f"to see {self._target.gain_m2:.2f} m² of unseen ground")
        self._enter("drive", now)

    def _arrive(self, now: float) -> None:
        assert self._target is not None
        if self._target.goal is not None:
            self.perception.count_views(self._target.goal)
            self._enter("inspect", now)
            return
        self.looks[self.unshown() & self.perception.in_view(self._target.pose)] += 1
        self._enter("decide", now)

    def _inspected(self, now: float) -> None:
        assert self._target is not None
        assert self._target.goal is not None
        goal = self._target.goal
        goal.attempts += 1
        if goal.state == PENDING:
            if self.perception.was_viewed(goal):
                goal.state, goal.inspected_at = INSPECTED, now
                if goal.place_id is not None:
                    self.perception.released.add(goal.place_id)
                self._note(now, f"{goal.id} inspected")
            elif goal.attempts >= MAX_ATTEMPTS:
                goal.state, goal.reason = UNREACHABLE, f"not in view from {goal.attempts} inspection poses"
                self._note(now, f"{goal.id} given up: {goal.reason}")
        self._enter("decide", now)

    # -- stops by the firmware -----------------------------------------------------------------------------------

    def _halt(self, now: float, firmware: FirmwareState) -> None:
        self.drive.halted(now)
        self.stops[firmware.cause] = self.stops.get(firmware.cause, 0) + 1
        self._note(now, f"the firmware stopped the rover: {firmware.cause}")
        self._enter("halted", now)

    def _recover(self, now: float, firmware: FirmwareState) -> Orders:
        if firmware.state in ("Armed", "Moving"):
            self._enter("decide", now)
            return Orders()
        if firmware.state == "Stopping" or now - self._since < REARM_DELAY:
            return Orders()
        if self._abort is not None:
            self._finish(now, self._abort)
            return Orders()
        cause = firmware.cause
        if self.stops.get(cause, 0) > REARM_LIMITS.get(cause, 0):
            self._finish(now, Outcome("safety_stop", f"the firmware stopped the rover: {cause}"))
            return Orders()
        self._since = now
        return Orders(arm=True)

    # -- bookkeeping ---------------------------------------------------------------------------------------------

    def _enter(self, phase: str, now: float) -> None:
        self.phase = phase
        self._since = now

    def _finish(self, now: float, outcome: Outcome) -> None:
        self.outcome = outcome
        self._note(now, f"{outcome.status}: {outcome.reason}")
        self._enter("finished", now)

    def _note(self, now: float, text: str) -> None:
        self.timeline.append((now, text))

    @property
    def pose(self) -> Pose2:
        """Where the rover believes to be."""
        return self.perception.pose
