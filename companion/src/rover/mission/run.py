"""Runs a mission on a rig: the edge where clocks, ports, files and the operator meet the survey.

Everything that enters the survey enters through `_cycle`, where it is recorded.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import rover_protocol.messages as messages

import rover
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput, LinkLost, PreflightFailed, SafetyStop
from rover.link.handshake import Identity
from rover.link.lockstep import LockstepRig, RigOptions, RigProcess
from rover.link.session import Link
from rover.mission.assemble import assemble
from rover.mission.config import Mission
from rover.mission.perception import Perception
from rover.mission.survey import Orders, Outcome, Survey
from rover.mission.track import Track
from rover.record.recording import Recording
from rover.record.tum import write_tum
from rover.report.result import Identities, RunResult, WallClock
from rover.report.write import write_run
from rover.vehicle import Vehicle
from rover.vision.camera_file import load_camera

CYCLE = 0.02
STATUS_PERIOD = 0.5
# After the mission's end the rover is disarmed; this long the link may take to confirm it.
DISARM_TIMEOUT = 2.0

SIMULATED = ("sitl", "emulator")
"""Rigs that bring their own world, camera and port."""


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


def run_mission(
    mission: Mission,
    *,
    rig: str = "sitl",
    transport: str = "serial",
    port: str | None = None,
    seed: int = 1,
    out: Path,
    data: Path | None = None,
    on_status: Callable[[Status], None] | None = None,
    control: Control | None = None,
) -> RunResult:
    """One whole mission; its folder `out` is complete when this returns, however the mission ended.

    Raises BadInput for what the user can correct and PreflightFailed when the rover may not start.
    """
    if rig not in SIMULATED:
        raise PreflightFailed(f"rig {rig}: no camera source for it yet; there is {', '.join(SIMULATED)}")
    if port is not None:
        raise BadInput(f"--port {port}: rig {rig} makes its own port")
    cv2.setNumThreads(1)
    out.mkdir(parents=True, exist_ok=True)
    _forget_earlier_run(out)
    classifier = Classifier(mission.detector.model or default_model())
    camera = load_camera(mission.rover.camera)
    survey = Survey(mission, Vehicle(), Perception(mission, Vehicle(), camera, classifier), seed)
    begin = time.monotonic()
    process = RigProcess(RigOptions(mission.path, rig, seed, out, data, transport=transport), out / "rig.log")
    try:
        (out / "rig.json").write_text(
            json.dumps({"port": process.port, "control": process.control, "pid": process.pid}) + "\n"
        )
        lockstep = LockstepRig(process.port, process.control, mission.rover.baud, pipeline=CYCLE)
        identities = _identities(mission, rig, seed, classifier)
        with Recording(out / "mission.mcap", {"mission": mission.name, "seed": str(seed), "rig": rig}) as recording:
            run = _Run(survey, lockstep, recording, on_status, control or Control(), seed)
            run.drive()
            identities = _with_firmware(identities, run.link.identity)
            referee = run.judge()
        lockstep.close()
    finally:
        process.stop()
    wall = time.monotonic() - begin
    assert survey.outcome is not None
    result = assemble(survey, run.track, run.link.figures(), identities, referee, out)
    result = replace(result, out=str(out), wall_clock=WallClock(wall, result.duration / wall))
    write_tum(out / "trajectory.tum", run.track.fused)
    write_run(result, out)
    return result


class _Run:
    """The loop of one mission over one link."""

    def __init__(
        self,
        survey: Survey,
        rig: LockstepRig,
        recording: Recording,
        on_status: Callable[[Status], None] | None,
        control: Control,
        seed: int,
    ) -> None:
        self.survey = survey
        self.rig = rig
        self.track = Track()
        self.recording = recording
        self.link = Link(rig.transport, rig, session=seed & 0xFFFF, tap=recording.link)
        self._on_status = on_status
        self._control = control
        self._status_due = 0.0
        self._begin = time.monotonic()
        self._noted = 0
        self._decisions = 0

    def drive(self) -> None:
        """From the handshake to the survey's outcome; a lost link or a restarted firmware is an outcome too."""
        survey = self.survey
        self.link.connect()
        try:
            while survey.outcome is None:
                self._cycle()
            self.link.disarm(DISARM_TIMEOUT)
        except LinkLost as error:
            survey.outcome = survey.outcome or Outcome("link_lost", str(error))
        except SafetyStop as error:
            survey.outcome = survey.outcome or Outcome("safety_stop", str(error))
        self._record_notes()

    def judge(self) -> dict[str, float | None] | None:
        """What the rig's referee saw; None when the rig is gone. Zones go to it as they were, version by version."""
        zones = [
            {"t": zone.since, "until": zone.until, "id": zone.id, "x": zone.x, "y": zone.y, "r": zone.radius}
            for zone in self.survey.perception.keepout.history
        ]
        detections = [
            {"id": place.id, "class": place.kind, "x": place.x, "y": place.y}
            for place in self.survey.perception.indications
        ]
        try:
            return self.rig.finish(zones, detections)
        except LinkLost:
            return None

    def _cycle(self) -> None:
        now = self.rig.now() + CYCLE
        self.rig.advance(now)
        telemetry = self.link.poll()
        frames = list(self.rig.frames)
        for event in telemetry:
            self.recording.telemetry(now, event)
        for frame in frames:
            self.recording.frame(now, frame)
        self._obey_operator()
        orders = self.survey.step(now, telemetry, frames, self.link.state)
        self._carry_out(orders)
        self._record(now, bool(frames))
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
                self.survey.outcome = Outcome("safety_stop", str(error))
        if orders.segments and orders.start is not None:
            self.link.stream.begin(orders.segments, orders.start)
        elif orders.segments:
            self.link.stream.extend(orders.segments)

    def _obey_operator(self) -> None:
        if self._control.emergency:
            self.link.emergency_stop()
            self.survey.outcome = Outcome("aborted", "emergency stop by the operator")
        elif self._control.stop:
            self.survey.abort(Outcome("aborted", "ended by the operator"))

    def _record(self, now: float, seen: bool) -> None:
        survey = self.survey
        perception = survey.perception
        self.track.add(now, perception.pose, perception.localizer.odometry_only, perception.sigma)
        if seen:
            self.recording.pose(now, perception.pose)
            if perception.last_fix is not None:
                self.recording.event("/localization/fix", now, perception.last_fix)
        if survey.decisions != self._decisions and survey.decision is not None:
            self._decisions = survey.decisions
            self.recording.path(now, survey.decision.path)
        self._record_notes()

    def _record_notes(self) -> None:
        for at, text in self.survey.timeline[self._noted :]:
            self.recording.log(at, "info", text)
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
            goals_done=sum(goal.state != "pending" for goal in goals),
            goals=len(goals),
            indications=len(perception.indications),
            surveyed=float((perception.grid.seen | perception.grid.occupied).mean()),
            battery=perception.battery.voltage if perception.battery else None,
            lost_frames=figures.lost + figures.firmware_lost,
            round_trip=figures.round_trip_median,
            wall=time.monotonic() - self._begin,
        )


def _forget_earlier_run(out: Path) -> None:
    """Files of an earlier run in the same folder must not be taken for this one's."""
    for name in (
        "mission.mcap",
        "summary.json",
        "report.html",
        "map.png",
        "detections.geojson",
        "trajectory.tum",
        "truth.tum",
        "truth.json",
        "rig.json",
        "rig.log",
    ):
        (out / name).unlink(missing_ok=True)


def _identities(mission: Mission, rig: str, seed: int, classifier: Classifier) -> Identities:
    return Identities(
        rig=rig,
        seed=seed,
        rover_version=rover.__version__,
        schema_hash=f"{messages.SCHEMA_HASH:08x}",
        model_hash=classifier.sha256[:12],
        mission_hash=hashlib.sha256(mission.path.read_bytes()).hexdigest()[:12],
    )


def _with_firmware(identities: Identities, identity: Identity | None) -> Identities:
    if identity is None:
        return identities
    return replace(
        identities,
        firmware_version=identity.version,
        firmware_git_hash=identity.git_hash,
        board=identity.board,
    )
