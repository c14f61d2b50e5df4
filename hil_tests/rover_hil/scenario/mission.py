"""Plays a scenario of a whole mission: the real `rover run` as a process, on a rig that puts faults in while it drives.

Time stands in lock step with the companion while it lives. When its process is frozen the world goes on without it;
when it is killed or has ended, the world goes on until the scenario is decided.
"""

from __future__ import annotations

import select
import signal
import socket
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover.errors import PreflightFailed
from rover.mission.config import load
from rover.vision.camera.file import load_camera

from rover_hil.ground import build
from rover_hil.plant_config import build_plant, describe_camera
from rover_hil.rig import Advance, RigFrame
from rover_hil.scenario.board_faults import FAULTY_RIGS, FaultyRig
from rover_hil.scenario.companion_process import CompanionProcess
from rover_hil.scenario.judge import Verdict
from rover_hil.scenario.language import Injection, Scenario
from rover_hil.scenario.observation import Track
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.watch import FAR_M, STEP_US, Over, Watch
from rover_hil.scenario.world_faults import WorldFaults
from rover_hil.serve import verdict_of
from rover_hil.session import Session

# Seconds until the companion has loaded its model and connects.
START_TIMEOUT_S = 120.0

# Seconds that the companion may think between two requests.
REQUEST_TIMEOUT_S = 120.0

# Of a companion that was killed nobody knows its zones and indications.
UNKNOWN = -1.0


class _Gone(Exception):
    """The companion's process has been killed in the middle of a request."""


def play_mission(scenario: Scenario, rig: str) -> tuple[tuple[Verdict, ...], Track, str]:
    """One run. Raises BadInput, PreflightFailed, RigFailed."""
    with tempfile.TemporaryDirectory(prefix="rover-scenario-") as folder:
        run = _Run(scenario, rig, Path(folder))
        try:
            over = run.to_the_end()
        finally:
            run.close()
        moment = run.watch.look_at_the_end(run.last_word())
        return tuple(run.watch.judge.finish(moment, over)), run.watch.track, run.companion.reason


class _Run:
    """One mission and all its parts. Is the rig that the companion talks to, see `rover_hil.rig.Rig`."""

    def __init__(self, scenario: Scenario, rig: str, folder: Path) -> None:
        assert scenario.mission is not None
        beside = scenario.path.parent / scenario.mission
        self._mission = load(beside if beside.suffix else scenario.mission)
        self._ground = build(self._mission, scenario.seed, None)
        model = load_camera(self._mission.rover.camera)
        camera = describe_camera(model)
        self._plant = build_plant(self._mission, self._ground, model, scenario.seed)
        self._rig: FaultyRig = FAULTY_RIGS[rig](self._plant, camera, self._mission.rover.baud, "serial")
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        control = folder / "control.sock"
        self._listener.bind(str(control))
        self._listener.listen(1)
        self.name, self.port, self.camera = rig, self._rig.port, camera
        self._probe = Probe()
        self._recorded = False
        self._host_bytes = 0
        self._verdict: dict[str, Any] | None = None
        self._frozen = False
        self.companion = CompanionProcess(beside, rig, scenario.seed, folder, self.port, control)
        self._world = WorldFaults(self._plant, self._rig)
        mines = np.array([[mine.x, mine.y, mine.radius] for mine in self._ground.mines]).reshape(-1, 3)
        self.watch = Watch(
            scenario, self._plant, self._rig, self._probe, self.companion, self, lambda x, y: nearest_mine(mines, x, y)
        )

    def to_the_end(self) -> bool:
        """Runs; False when it had to be ended at the scenario's longest duration."""
        try:
            self.watch.begin()
            self._with_the_companion()
            while True:
                self.advance_free(self.now_us + STEP_US)
        except Over:
            return self.watch.settled_at is not None

    def last_word(self) -> dict[str, float]:
        """What is judged when all is over."""
        judged = self._verdict or verdict_of(self._rig, self._mission, self._ground, [], [])
        word = {"mines_driven_over": float(judged["wheel_over_mine"])}
        told = ("keepout_violations", "mines_with_contrast_found", "false_indications")
        return word | {name: float(judged[name]) if self._verdict else UNKNOWN for name in told}

    def close(self) -> None:
        """Ends the companion, firmware and wire."""
        self.companion.close()
        self._listener.close()
        self._rig.close()

    def _with_the_companion(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT_S
        while not select.select([self._listener], [], [], 0.2)[0]:
            if self.companion.ended or time.monotonic() > deadline:
                raise PreflightFailed(f"'rover run' did not start its mission: {self.companion.last_line}")
        connection, _ = self._listener.accept()
        connection.settimeout(REQUEST_TIMEOUT_S)
        with connection:
            try:
                Session(self, self._finish).serve(connection)
            except _Gone:
                return
        self.companion.wait()

    def _finish(self, zones: list[dict[str, Any]], detections: list[dict[str, Any]]) -> dict[str, Any]:
        self._verdict = verdict_of(self._rig, self._mission, self._ground, zones, detections)
        return self._verdict

    def _step(self, to_us: int) -> Advance:
        step = self._rig.advance(to_us, self._host_bytes)
        self._probe.feed(self.now_us * 1e-6, step.from_firmware)
        if self.companion.armed_at is None and self._probe.values["state"] == "Armed":
            self.companion.armed_at = self.now_us * 1e-6
            self.companion.word = "Driving"
        self.watch.look()
        return step

    # -- the rig that the companion sees ---------------------------------------------------------------------------

    @property
    def now_us(self) -> int:
        """Virtual time, µs."""
        return self._rig.now_us

    def begin_session(self) -> None:
        """The companion has come."""
        self._rig.begin_session()
        self._rig.record()

    def record(self) -> None:
        """It wants ticks and bytes."""
        self._recorded = True

    def advance(self, to_us: int, host_bytes: int) -> Advance:
        """Runs until `to_us`, and on for as long as the companion's process is frozen meanwhile."""
        self._host_bytes = host_bytes
        steps: list[Advance] = []
        while self.now_us < to_us or self._frozen:
            until = self.now_us + STEP_US
            steps.append(self._step(min(until, to_us) if self.now_us < to_us else until))
            if self.companion.word == "Killed":
                raise _Gone
        frames: tuple[RigFrame, ...] = tuple(frame for step in steps for frame in step.frames)
        marks = tuple(mark for step in steps for mark in step.marks)
        if not self._recorded:
            return Advance(self.now_us, marks, frames)
        parts = [b"".join(getattr(s, part) for s in steps) for part in ("ticks", "to_firmware", "from_firmware")]
        return Advance(self.now_us, marks, frames, *parts)

    def advance_free(self, to_us: int) -> tuple[RigFrame, ...]:
        """The world goes on without the companion; what the firmware sends nobody reads."""
        while self.now_us < to_us:
            self._step(min(self.now_us + STEP_US, to_us))
            self._rig.drop_unread()
        return ()

    def set_emergency_stop(self, active: bool) -> None:
        """The companion's own test of the input."""
        self._rig.set_emergency_stop(active)

    def truth(self) -> NDArray[np.float64]:
        """True trajectory (n, 4): time s, x, y, heading."""
        return self._rig.truth()

    def verdict(self) -> dict[str, Any]:
        """The plant's referee."""
        return self._rig.verdict()

    # -- faults ----------------------------------------------------------------------------------------------------

    def begin(self, injection: Injection) -> None:
        """The fault begins."""
        if self._world.switch(injection, True):
            return
        match injection.fault:
            case "companion-killed":
                self.companion.kill()
            case "companion-frozen":
                self._frozen = True
                self.companion.signal(signal.SIGSTOP)
            case "operator-stop":
                self.companion.signal(signal.SIGINT)

    def end(self, injection: Injection) -> None:
        """A lasting fault is over."""
        if not self._world.switch(injection, False) and injection.fault == "companion-frozen":
            self._frozen = False
            self.companion.signal(signal.SIGCONT)


def nearest_mine(mines: NDArray[np.float64], x: float, y: float) -> dict[str, float]:
    """Distance from a place to the edge of the nearest of `mines` (n, 3): x, y, radius."""
    if not len(mines):
        return {"mine_m": FAR_M}
    return {"mine_m": float((np.hypot(mines[:, 0] - x, mines[:, 1] - y) - mines[:, 2]).min())}
