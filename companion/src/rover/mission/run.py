"""Runs a mission on a rig: the edge where clocks, ports, files and the operator meet the survey.

What happens in between is `rover.mission.loop`.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import rover_protocol.messages as messages

import rover
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput, PreflightFailed
from rover.link.handshake import Identity
from rover.link.lockstep import LockstepRig, RigOptions, RigProcess
from rover.mission.assemble import assemble
from rover.mission.config import Mission
from rover.mission.loop import CYCLE, Control, MissionLoop, Status
from rover.mission.origin import attach_files, origin_of
from rover.mission.perception import Perception
from rover.mission.survey import Survey
from rover.record.recording import Recording
from rover.record.tum import write_tum
from rover.report.result import Identities, RunResult, WallClock
from rover.report.write import write_run
from rover.vehicle import Vehicle
from rover.vision.camera_file import load_camera

SIMULATED = ("sitl", "emulator")
"""Rigs that bring their own world, camera and port."""


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
        identities = _identities(mission, rig, seed, classifier)
        origin = origin_of(mission, rig, transport, seed, CYCLE, classifier.sha256)
        with Recording(out / "mission.mcap", origin) as recording:
            attach_files(recording, mission)
            lockstep = LockstepRig(process.port, process.control, mission.rover.baud, CYCLE, recording.step)
            run = MissionLoop(survey, lockstep, recording, on_status, control or Control(), seed)
            run.drive()
            identities = _with_firmware(identities, run.link.identity)
            referee = run.judge()
            recording.identify("firmware", _firmware(run.link.identity))
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


def _firmware(identity: Identity | None) -> dict[str, str]:
    """What the firmware said of itself, for the log."""
    if identity is None:
        return {}
    return {"version": identity.version, "git_hash": identity.git_hash, "board": identity.board}


def _with_firmware(identities: Identities, identity: Identity | None) -> Identities:
    if identity is None:
        return identities
    return replace(
        identities,
        firmware_version=identity.version,
        firmware_git_hash=identity.git_hash,
        board=identity.board,
    )
