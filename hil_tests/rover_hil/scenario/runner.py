"""Plays a scenario on a rig: world, firmware and companion in lock step, faults where the scenario says."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from rover.errors import BadInput
from rover_plant import Plant

from rover_hil.scenario.driver import Companion
from rover_hil.scenario.host import Host
from rover_hil.scenario.injector import Injector
from rover_hil.scenario.judge import Judge, Verdict
from rover_hil.scenario.language import START, Injection, Scenario
from rover_hil.scenario.observation import Moment, Track
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.stage import build_rig, build_stage, build_wire
from rover_hil.scenario.wire_faults import WireFaults

STEP_US = 5_000
"""The world is looked at this often: the resolution of every time in a scenario."""

LOOK_EVERY = 10
FAR = 99.0
"""Clearance when there is nothing to keep clear of, metres."""


class _Over(Exception):
    """The scenario has come to its end."""


@dataclass(frozen=True)
class Result:
    """What came of a scenario on a rig."""

    scenario: Scenario
    rig: str
    verdicts: tuple[Verdict, ...]
    track: Track
    reason: str
    simulated: float
    wall: float

    @property
    def passed(self) -> bool:
        """True when everything held that was asked for."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def failures(self) -> list[str]:
        """One line for each thing that did not hold."""
        return [f"{v.name}: {v.asked}: {v.detail}" for v in self.verdicts if not v.passed]


def play(scenario: Scenario, rig: str) -> Result:
    """One run; the same scenario on the same build gives the same result.

    Raises BadInput, PreflightFailed, RigFailed.
    """
    if scenario.mission is not None:
        raise BadInput(f"{scenario.path}: drive.mission: whole missions are not driven here yet; give drive.steps")
    begin = time.monotonic()
    run = _Run(scenario, rig)
    try:
        over = run.to_the_end()
    finally:
        run.close()
    moment = run.track.last
    verdicts = tuple(run.judge.finish(moment, over))
    return Result(scenario, rig, verdicts, run.track, run.companion.reason, moment.time, time.monotonic() - begin)


class _Run:
    """One run and all its parts."""

    def __init__(self, scenario: Scenario, rig: str) -> None:
        self._scenario = scenario
        self._plant = build_stage(scenario)
        self._rig = build_rig(scenario, rig, self._plant)
        self._probe = Probe()
        self._faults = WireFaults(scenario.seed)
        self._host = Host(self._step)
        try:
            self._rig.begin_session()
            self._wire = build_wire(scenario, self._rig.port, self._faults, self._probe, self._host.from_world)
            self.companion = Companion(scenario.drive, self._wire, self._host, scenario.seed)
        except BaseException:
            self._rig.close()
            raise
        self._host.on_wake = self._wire.restamp
        self._injector = Injector(self._plant, self._rig, self._faults, self._host, self.companion, self._probe)
        self.judge = Judge(scenario)
        self.track = Track()
        self._waiting = list(scenario.injections)
        self._lasting: list[tuple[float, Injection]] = []
        self._times: dict[str, float] = {}
        self._travelled = self._turned = 0.0
        self._pose = self._launch = self._plant.pose()
        self._referee: dict[str, float] = {}
        self._settled_at: float | None = None
        self._companion_word = ""

    def to_the_end(self) -> bool:
        """Runs; False when it had to be ended at the scenario's longest duration."""
        try:
            self._look()
            self._inject()
            self.companion.live({int(key): value for key, value in self._scenario.parameters.items()})
            while True:
                self._step()
        except _Over:
            last = self.track.moments.pop()
            self.track.moments.append(Moment(last.time, {**last.values, **look_at_referee(self._plant)}))
            return self._settled_at is not None

    def close(self) -> None:
        """Ends firmware and wire."""
        self._wire.close()
        self._rig.close()

    def _step(self) -> float:
        """The world goes on by STEP_US; returns its time in seconds."""
        before_us = self._rig.now_us
        advance = self._rig.advance(before_us + STEP_US, self._wire.host_bytes)
        self._wire.announce(list(advance.marks))
        now = self._rig.now_us * 1e-6
        self._wire.pump(now)
        self._look()
        self._inject()
        self._end_lasting(now)
        for name in self.judge.see(self.track.last):
            self._happened(name, f"expected: {name}")
        self._check_over(now)
        return now

    def _look(self) -> None:
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
            companion=self.companion.word,
            driving=self.companion.driving,
            **self._referee,
        )
        self.track.moments.append(Moment(now, values))
        self._note_events(now)

    def _note_events(self, now: float) -> None:
        self.track.events += self._probe.events
        self._probe.events.clear()
        if self.companion.word != self._companion_word:
            self._companion_word = self.companion.word
            why = f": {self.companion.reason}" if self.companion.reason else ""
            self.track.events.append((now, f"companion: {self.companion.word}{why}"))
        if self.companion.armed_at is not None and START not in self._times:
            self._happened(START, "start of the drive")

    def _inject(self) -> None:
        now = self.track.last.time
        for injection in list(self._waiting):
            if self._due(injection, now):
                self._waiting.remove(injection)
                self._happened(injection.name, f"fault: {injection.fault}")
                self._injector.begin(injection)
                if injection.duration is not None:
                    self._lasting.append((now + injection.duration, injection))

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
                self._injector.end(injection)

    def _happened(self, name: str, text: str) -> None:
        moment = self.track.last
        self._times.setdefault(name, moment.time)
        self.judge.event(name, moment)
        self.track.events.append((moment.time, text))

    def _check_over(self, now: float) -> None:
        busy = self._waiting or self._lasting or self.companion.driving or not self.judge.decided
        if busy:
            self._settled_at = None
        elif self._settled_at is None:
            self._settled_at = now
        if self._settled_at is not None and now >= self._settled_at + self._scenario.settle:
            raise _Over
        if now >= self._scenario.max_duration:
            self._settled_at = None
            raise _Over


def look_at_referee(plant: Plant) -> dict[str, float]:
    """Collisions so far, and the clearance at the nearest obstacle so far."""
    verdict = plant.verdict()
    clearance = verdict["min_clearance_m"]
    return {
        "collisions": float(verdict["collisions"] or 0),
        "clearance_m": FAR if clearance is None else float(clearance),
    }
