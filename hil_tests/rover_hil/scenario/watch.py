"""Looks at a running world every few milliseconds: what is seen of it, which faults are due, what the judge says."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from rover_plant import Plant

from rover_hil.scenario.board_faults import FaultyRig
from rover_hil.scenario.judge import Judge
from rover_hil.scenario.language import START, Injection, Scenario
from rover_hil.scenario.observation import Moment, Track
from rover_hil.scenario.probe import Probe

# The world is looked at this often: the resolution of every time in a scenario.
STEP_US = 5_000

LOOK_EVERY = 10
# Clearance when there is nothing to keep clear of, metres.
FAR_M = 99.0

Extra = Callable[[float, float], dict[str, float]]
"""From the rover's true x and y to more of what is observed."""


class Over(Exception):
    """The scenario has come to its end."""


class Driving(Protocol):
    """How the companion fares; the words are those of `observation.py`."""

    word: str
    reason: str
    armed_at: float | None

    @property
    def driving(self) -> bool:
        """False once it has nothing more to do."""
        ...


class Injecting(Protocol):
    """What puts faults in and takes them out."""

    def begin(self, injection: Injection) -> None:
        """The fault begins."""
        ...

    def end(self, injection: Injection) -> None:
        """A lasting fault is over."""
        ...


class Watch:
    """The course of one run. `look` comes after each step of the world."""

    def __init__(
        self,
        scenario: Scenario,
        plant: Plant,
        rig: FaultyRig,
        probe: Probe,
        companion: Driving,
        injecting: Injecting,
        extra: Extra = lambda x, y: {},
    ) -> None:
        self.judge = Judge(scenario)
        self.track = Track()
        self.settled_at: float | None = None
        self._scenario = scenario
        self._plant = plant
        self._rig = rig
        self._probe = probe
        self._companion = companion
        self._injecting = injecting
        self._extra = extra
        self._waiting = list(scenario.injections)
        self._lasting: list[tuple[float, Injection]] = []
        self._times: dict[str, float] = {}
        self._travelled = self._turned = 0.0
        self._pose = self._launch = plant.pose()
        self._referee: dict[str, float] = {}
        self._word = ""

    def begin(self) -> None:
        """The moment of switching on, with the faults that are there from the beginning."""
        self._observe()
        self._inject()

    def look(self) -> None:
        """What the last step has brought. Raises Over."""
        now = self._rig.now_us * 1e-6
        self._observe()
        self._inject()
        self._end_lasting(now)
        for name in self.judge.see(self.track.last):
            self._happened(name, f"expected: {name}")
        self._check_over(now)

    def look_at_the_end(self, more: dict[str, float]) -> Moment:
        """The last moment once more, with the referee's final word and `more`."""
        last = self.track.moments.pop()
        moment = Moment(last.time, {**last.values, **look_at_referee(self._plant), **more})
        self.track.moments.append(moment)
        return moment

    def _observe(self) -> None:
        plant, values = self._plant, dict(self._probe.values)
        now = self._rig.now_us * 1e-6
        x, y, heading = plant.pose()
        moved, turned = math.hypot(x - self._pose[0], y - self._pose[1]), abs(heading - self._pose[2])
        self._pose = (x, y, heading)
        self._travelled += moved
        self._turned += turned
        if len(self.track.moments) % LOOK_EVERY == 0:
            self._referee = look_at_referee(plant)
        left, right, powered = plant.duty()
        x0, y0, launch = self._launch
        values.update(
            time_s=now,
            speed=moved / (STEP_US * 1e-6),
            turn_rate=turned / (STEP_US * 1e-6),
            travelled_m=self._travelled,
            turned_deg=math.degrees(self._turned),
            advance_m=(x - x0) * math.cos(launch) + (y - y0) * math.sin(launch),
            heading_deg=math.degrees(heading - launch),
            battery_v=plant.battery()[0],
            duty=max(abs(left), abs(right)) if powered else 0.0,
            powered=powered,
            buzzer=plant.signals()[1],
            companion=self._companion.word,
            driving=self._companion.driving,
            **self._referee,
            **self._extra(x, y),
        )
        self.track.moments.append(Moment(now, values))
        self._note_events(now)

    def _note_events(self, now: float) -> None:
        self.track.events += self._probe.events
        self._probe.events.clear()
        if self._companion.word != self._word:
            self._word = self._companion.word
            why = f": {self._companion.reason}" if self._companion.reason else ""
            self.track.events.append((now, f"companion: {self._word}{why}"))
        if self._companion.armed_at is not None and START not in self._times:
            self._happened(START, "start of the drive")

    def _inject(self) -> None:
        now = self.track.last.time
        for injection in list(self._waiting):
            if self._due(injection, now):
                self._waiting.remove(injection)
                self._happened(injection.name, f"fault: {injection.fault}")
                if injection.duration is not None:
                    self._lasting.append((now + injection.duration, injection))
                self._injecting.begin(injection)

    def _due(self, injection: Injection, now: float) -> bool:
        if injection.from_boot:
            return True
        if injection.when is not None:
            return injection.when(self.track.last.values)
        reference = self._times.get(injection.after or START)
        return reference is not None and now >= reference + (injection.at or 0.0) - 1e-9

    def _end_lasting(self, now: float) -> None:
        for until, injection in list(self._lasting):
            if now >= until - 1e-9:
                self._lasting.remove((until, injection))
                self.track.events.append((now, f"over: {injection.fault}"))
                self._injecting.end(injection)

    def _happened(self, name: str, text: str) -> None:
        moment = self.track.last
        self._times.setdefault(name, moment.time)
        self.judge.event(name, moment)
        self.track.events.append((moment.time, text))

    def _awaited(self) -> bool:
        """Whether a fault may still come: none that waits for a moment of a drive which another one has ended."""
        names = {injection.name for injection in self._scenario.injections}
        ended = not self._companion.driving and bool(self._scenario.expectations) and bool(names & set(self._times))
        return any(injection.when is None or not ended for injection in self._waiting)

    def _check_over(self, now: float) -> None:
        busy = self._awaited() or self._lasting or self._companion.driving or not self.judge.decided
        if busy:
            self.settled_at = None
        elif self.settled_at is None:
            self.settled_at = now
        if self.settled_at is not None and now >= self.settled_at + self._scenario.settle:
            raise Over
        if now >= self._scenario.max_duration:
            self.settled_at = None
            raise Over


def look_at_referee(plant: Plant) -> dict[str, float]:
    """Collisions and unseen ground driven on so far, and the clearance at the nearest obstacle so far."""
    verdict = plant.verdict()
    clearance = verdict["min_clearance_m"]
    return {
        "collisions": float(verdict["collisions"] or 0),
        "bumper_contacts": float(verdict["bumper_contacts"] or 0),
        "clearance_m": FAR_M if clearance is None else float(clearance),
        "unseen_m2": float(verdict["unseen_ground_m2"] or 0.0),
    }
