"""Runs a mission on a rig: the edge where clocks, ports, files and the operator meet the survey.

What happens in between is `rover.mission.loop`.
"""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2

from rover.detection.classifier import Classifier, default_model
from rover.errors import Aborted, BadInput
from rover.link.claim import mission_on
from rover.link.device import DeviceRig
from rover.link.handshake import Identity
from rover.link.port import CanPort, parse_port
from rover.link.rig import Rig, RigName, RigOptions, start_rig
from rover.link.self_test import Finding
from rover.link.statistics import LinkFigures
from rover.mission.assemble import assemble
from rover.mission.begin import begin
from rover.mission.checkpoint import Checkpoint
from rover.mission.config import Mission
from rover.mission.device import check, opened
from rover.mission.ear import Ear
from rover.mission.former_run import load_run
from rover.mission.loop import CYCLE, Control, MissionLoop, Status
from rover.mission.origin import attach_files, identities_of, origin_of
from rover.mission.outputs import write_outputs
from rover.mission.run_folder import RunFolder
from rover.mission.survey import Survey
from rover.mission.track import Track
from rover.mission.visit_again import check_same_field
from rover.record.epoch import Epoch, simulated_epoch, system_epoch
from rover.record.foxglove_stream import FoxgloveStream
from rover.record.manifest import private_key
from rover.record.recording import Recording
from rover.record.topics import CAMERA_LOST
from rover.report.pdf import require_pdf
from rover.report.result import RealTime, RunResult, WallClock
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

# A real rover, on a port, with a camera; the other rigs bring a world, camera and port of their own.
DEVICE = RigName.DEVICE.value


@dataclass(frozen=True)
class Driven:
    """What a mission leaves behind on its way; the link's figures are those of before its port is closed."""

    track: Track
    firmware: Identity | None
    figures: LinkFigures
    referee: dict[str, Any] | None
    epoch: Epoch


@dataclass(frozen=True)
class _Prepared:
    """A mission that is ready to be driven."""

    mission: Mission
    survey: Survey
    classifier: Classifier
    camera: CameraModel
    rig: str
    transport: str
    seed: int
    session: int
    folder: RunFolder
    on_status: Callable[[Status], None] | None
    control: Control
    resume: Path | None
    live: FoxgloveStream | None
    after: Path | None

    def drive(self, rig: Rig, recording: Recording) -> Driven:
        """The whole mission on a rig, into a log."""
        mission_on(rig.transport.port, self.folder.path)
        with Checkpoint(self.survey, self.folder.path) as checkpoint, Ear(self.folder.path) as ear:
            run = MissionLoop(
                self.survey,
                rig,
                recording,
                self.on_status,
                self.control,
                self.session,
                keep=lambda now: recording.failure or checkpoint.keep(now),
                ear=ear,
            )
            try:
                run.drive()
            except BaseException:  # a mistake of ours: nobody plans for the rover from here on
                with suppress(Exception):
                    run.link.stop()
                raise
        referee = run.judge()
        recording.identify("firmware", _firmware(run.link.identity))
        return Driven(run.track, run.link.identity, run.link.figures(), referee, recording.epoch)

    def heed_operator(self) -> None:
        """Raises Aborted when he has said stop before anything was armed: no run is made."""
        if self.control.stop or self.control.emergency:
            raise Aborted("ended by the operator before the rover was armed; nothing has moved")

    def recording(self, epoch: Epoch, more: Mapping[str, str] | None = None) -> Recording:
        """The log, with what the run is made from. `epoch`: when mission time 0 is."""
        origin = origin_of(self.mission, self.rig, self.transport, self.seed, CYCLE, self.classifier.sha256)
        visit = {} if self.after is None else {"visit_after": self.after.resolve().name}
        described = {**origin, **visit, **(more or {})}
        recording = Recording(self.folder.path / "mission.mcap", described, epoch, self.live)
        attach_files(recording, self.mission, self.resume, self.after)
        return recording


def run_mission(
    mission: Mission,
    *,
    rig: str = "sitl",
    transport: str = "serial",
    port: str | None = None,
    camera_source: str | None = None,
    seed: int = 1,
    out: Path,
    force: bool = False,
    data: Path | None = None,
    resume: Path | None = None,
    after: Path | None = None,
    on_status: Callable[[Status], None] | None = None,
    on_finding: Callable[[Finding], None] = lambda _: None,
    control: Control | None = None,
    live: FoxgloveStream | None = None,
    key: Path | None = None,
    pdf: bool = False,
) -> RunResult:
    """One whole mission; its folder `out` is complete when this returns, however the mission ended.

    `out`: new or empty; with `force` what an earlier run left there goes once the pre-flight check has passed. When
    that fails, nothing is made and nothing is gone. What could not be written is named in the result.
    `resume`: the folder of an earlier run over the same area, whose knowledge this one begins with.
    `after`: the folder of a survey of the same field at another hour: both are fused in the end.
    `live`: is given all that is written into the log.
    `key`: of the operator, to sign the run's manifest with. `pdf`: the report as a PDF, too.
    `port`, `camera_source`: of a real rover, on rig "device" alone; `on_finding` is told what its check finds.

    Raises BadInput for what the user can correct, PreflightFailed when the rover may not start, and Aborted when it is
    not wanted to any more.
    """
    if rig not in [name.value for name in RigName]:
        raise BadInput(f"--rig {rig}: not known; there is {', '.join(name.value for name in RigName)}")
    if rig != DEVICE:
        if port is not None:
            raise BadInput(f"--port {port}: rig {rig} makes its own port")
        if camera_source is not None:
            raise BadInput(f"--camera-source {camera_source}: rig {rig} has a camera of its own")
    elif data is not None:
        raise BadInput(f"--data {data}: lays the ground of a simulated field; a real one has its own")
    elif port is not None:
        transport = "can" if isinstance(parse_port(port), CanPort) else "serial"
    cv2.setNumThreads(1)
    if pdf:
        require_pdf()
    signer = None if key is None else private_key(key)
    camera = load_camera(mission.rover.camera)
    if resume is not None and resume.resolve() == out.resolve():
        raise BadInput(f"--out {out}: the run to go on from is there; name another folder")
    if after is not None and resume is not None:
        raise BadInput("--after and --resume: a run goes on from an earlier one, or is the second visit after it")
    if after is not None and after.resolve() == out.resolve():
        raise BadInput(f"--out {out}: the earlier visit is there; name another folder")
    if after is not None and rig != DEVICE:
        check_same_field(after, seed)
    former = load_run(resume, mission, camera) if resume is not None else None
    earlier = load_run(after, mission, camera) if after is not None else None
    classifier = Classifier(mission.detector.model or default_model())
    survey = begin(mission, camera, classifier, seed, former, earlier)
    # A board tells the companions that it hears one after the other apart by this; a simulated one is always a new one.
    session = secrets.randbelow(1 << 16) if rig == DEVICE else seed & 0xFFFF
    with RunFolder(out, force) as folder:
        prepared = _Prepared(
            mission,
            survey,
            classifier,
            camera,
            rig,
            transport,
            seed,
            session,
            folder,
            on_status,
            control or Control(),
            resume,
            live,
            after,
        )
        started = time.monotonic()
        real_time = None
        if rig == DEVICE:
            driven, real_time = _on_device(prepared, port, camera_source, on_finding)
        else:
            driven = _on_simulated(prepared, data)
        wall = time.monotonic() - started
        assert survey.outcome is not None
        gone_on_from = "" if resume is None else resume.resolve().name
        identities = identities_of(mission, rig, seed, classifier.sha256, driven.firmware, gone_on_from)
        result = assemble(survey, driven.track, driven.figures, identities, driven.referee, out, driven.epoch)
        clock = None if rig == DEVICE else WallClock(wall, result.duration / wall)
        result = replace(result, out=str(out), wall_clock=clock, real_time=real_time)
        return write_outputs(result, survey, driven.track, signer, pdf)


def _on_simulated(prepared: _Prepared, data: Path | None) -> Driven:
    """In virtual time, on a rig that is started for it."""
    mission, folder = prepared.mission, prepared.folder
    options = RigOptions(
        mission.path,
        prepared.rig,
        prepared.seed,
        folder.path,
        data,
        transport=prepared.transport,
        former=prepared.resume,
    )
    process = start_rig(options, folder.rig_log)
    try:
        prepared.heed_operator()
        folder.accept()
        (folder.path / "rig.json").write_text(
            json.dumps({"port": process.port, "control": process.control, "pid": process.pid}) + "\n"
        )
        longitude = None if mission.site.origin is None else mission.site.origin.longitude
        epoch = simulated_epoch(mission.site.day, mission.time_of_day_s, longitude)
        with prepared.recording(epoch) as recording:
            simulated = process.connect(mission.rover.baud, CYCLE, recording.step)
            driven = prepared.drive(simulated, recording)
        simulated.close()
        return driven
    finally:
        process.stop()


def _on_device(
    prepared: _Prepared, port: str | None, camera_source: str | None, on_finding: Callable[[Finding], None]
) -> tuple[Driven, RealTime]:
    """In real time, on a rover and a camera that are there."""
    with opened(prepared.mission, port, camera_source) as device:
        check(device, prepared.mission, prepared.camera, prepared.folder.path, prepared.seed, on_finding)
        prepared.heed_operator()
        prepared.folder.accept()
        wire = {"port": device.wire.port, "byte_time_s": repr(device.byte_time), "session": str(prepared.session)}
        with prepared.recording(system_epoch(device.clock.now()), wire) as recording:
            rig = DeviceRig(device.wire, device.camera, device.clock, recording.cycle)
            driven = prepared.drive(rig, recording)
            if rig.camera_failure is not None:
                recording.event(CAMERA_LOST, rig.now(), {"text": rig.camera_failure})
                prepared.survey.timeline.append((rig.now(), f"camera: {rig.camera_failure}"))
        pace = rig.pace
    return driven, RealTime(pace.cycles, pace.overruns, pace.longest, pace.frames_dropped)


def _firmware(identity: Identity | None) -> dict[str, str]:
    """What the firmware said of itself, for the log."""
    if identity is None:
        return {}
    return {"version": identity.version, "git_hash": identity.git_hash, "board": identity.board}
