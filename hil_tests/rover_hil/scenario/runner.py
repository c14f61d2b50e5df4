"""Plays a scenario on a rig: world, firmware and companion in lock step, faults where the scenario says."""

from __future__ import annotations

import time
from dataclasses import dataclass

from rover_hil.scenario.driver import Companion
from rover_hil.scenario.host import Host
from rover_hil.scenario.injector import Injector
from rover_hil.scenario.judge import Verdict
from rover_hil.scenario.language import Scenario
from rover_hil.scenario.observation import Track
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.stage import build_rig, build_stage, build_wire
from rover_hil.scenario.watch import STEP_US, Over, Watch
from rover_hil.scenario.wire_faults import WireFaults


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
    begin = time.monotonic()
    if scenario.mission is not None:
        from rover_hil.scenario.mission import play_mission  # brings the whole companion with it

        verdicts, track, reason = play_mission(scenario, rig)
    else:
        verdicts, track, reason = _play_drive(scenario, rig)
    return Result(scenario, rig, verdicts, track, reason, track.last.time, time.monotonic() - begin)


def _play_drive(scenario: Scenario, rig: str) -> tuple[tuple[Verdict, ...], Track, str]:
    run = _Run(scenario, rig)
    try:
        over = run.to_the_end()
    finally:
        run.close()
    moment = run.watch.look_at_the_end({})
    return tuple(run.watch.judge.finish(moment, over)), run.watch.track, run.companion.reason


class _Run:
    """A scripted drive and all its parts."""

    def __init__(self, scenario: Scenario, rig: str) -> None:
        self._scenario = scenario
        plant = build_stage(scenario)
        self._rig = build_rig(scenario, rig, plant)
        probe, faults = Probe(), WireFaults(scenario.seed)
        self._host = Host(self._step)
        try:
            self._rig.begin_session()
            self._wire = build_wire(scenario, self._rig.port, faults, probe, self._host.from_world)
            self.companion = Companion(scenario.drive, self._wire, self._host, scenario.seed)
        except BaseException:
            self._rig.close()
            raise
        self._host.on_wake = self._wire.restamp
        injector = Injector(plant, self._rig, faults, self._host, self.companion, probe)
        self.watch = Watch(scenario, plant, self._rig, probe, self.companion, injector)

    def to_the_end(self) -> bool:
        """Runs; False when it had to be ended at the scenario's longest duration."""
        try:
            self.watch.begin()
            self.companion.live({int(key): value for key, value in self._scenario.parameters.items()})
            while True:
                self._step()
        except Over:
            return self.watch.settled_at is not None

    def close(self) -> None:
        """Ends firmware and wire."""
        self._wire.close()
        self._rig.close()

    def _step(self) -> float:
        """The world goes on by STEP_US; returns its time in seconds."""
        advance = self._rig.advance(self._rig.now_us + STEP_US, self._wire.host_bytes)
        self._wire.announce(list(advance.marks))
        now = self._rig.now_us * 1e-6
        self._wire.pump(now)
        self.watch.look()
        return now
