"""Report and survey of a run out of its log, however the run ended: the mission's own loop goes over what came in."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
from google.protobuf.message import Message
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput, RoverError
from rover.link.rig import Rig
from rover.mission.assemble import assemble
from rover.mission.begin import begin
from rover.mission.loop import Control, MissionLoop
from rover.mission.origin import identities_of, restore_earlier, restore_former, restore_mission, session_of
from rover.mission.outputs import write_outputs
from rover.mission.run import DEVICE
from rover.mission.run_folder import RunFolder
from rover.mission.survey import Survey
from rover.outcome import Outcome, RunStatus
from rover.record.journal import Journal
from rover.record.log_reader import Log
from rover.report.result import RunResult
from rover.vision.camera.file import load_camera

from rover_hil.former_world import SEEN
from rover_hil.replay.estimators import IMPORTED
from rover_hil.replay.recorded_device import RecordedDevice
from rover_hil.replay.recorded_rig import RecordedOperator, RecordedRig, RecordedWorld

LOG_NAME = "mission.mcap"
TRUTH_FILES = ("truth.tum", "truth.json", SEEN)


def log_of(given: Path) -> Path:
    """The log that is meant: the file itself, or the one in a run's folder."""
    return given / LOG_NAME if given.is_dir() else given


def recover(
    given: Path, out: Path, force: bool = False, on_time: Callable[[float], None] = lambda _: None
) -> RunResult:
    """What the run in `given` (its log, or its folder) had found out until its log ends, written into `out`.

    `on_time` is told how far it is, seconds. The referee of a simulated rig has seen nothing of this. Raises BadInput.
    """
    log = Log(log_of(given))
    origin = log.metadata.get("mission")
    if origin is None or "source_hash" not in origin or origin["rig"] == IMPORTED:
        raise BadInput(f"{log.path}: not the log of a mission, or cut before it began: nothing to recover")
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory(prefix="rover-recover-") as folder, RunFolder(out, force) as target:
        scratch = Path(folder)
        mission = replace(restore_mission(log.files, scratch, {}), name=origin["mission"])
        classifier = Classifier(mission.detector.model or default_model())
        camera = load_camera(mission.rover.camera)
        seed = int(origin["seed"])
        former = restore_former(log.files, scratch, mission, camera)
        earlier = restore_earlier(log.files, scratch, mission, camera, origin.get("visit_after", ""))
        survey = begin(mission, camera, classifier, seed, former, earlier)
        control = Control()
        operator = RecordedOperator(log, control)

        def on_arrival(now_us: int) -> None:
            on_time(now_us * 1e-6)
            operator.act(now_us)

        loop = _drive(log, survey, control, on_arrival, scratch)
        until = loop.track.start + loop.track.duration
        # Where the log is cut the link seems lost: it is the log that ends there.
        ended = survey.outcome is not None and survey.outcome.status is not RunStatus.LINK_LOST
        if not ended and (log.cut or survey.outcome is None):
            survey.outcome = Outcome(RunStatus.PARTIAL, f"the run was cut off: recovered from its log, {until:.1f} s")
        identities = identities_of(mission, origin["rig"], seed, classifier.sha256, loop.link.identity)
        result = assemble(survey, loop.track, loop.link.figures(), identities, None, log.path.parent, log.epoch)
        target.accept()
        _copy_truth(log.path.parent, out)
        return write_outputs(replace(result, out=str(out), recovered_until=until), survey, loop.track)


def _drive(log: Log, survey: Survey, control: Control, on_arrival: Callable[[int], None], scratch: Path) -> MissionLoop:
    """The mission's loop over the log, up to the end of either."""

    def drive(rig: Rig) -> MissionLoop:
        loop = MissionLoop(survey, rig, Silence(), None, control, session_of(log.metadata["mission"]))
        with contextlib.suppress(RoverError):  # a handshake that did not come to its end
            loop.drive()
        return loop

    if log.metadata["mission"]["rig"] == DEVICE:
        return drive(RecordedDevice(log, on_arrival))
    recorded = RecordedRig(log, lambda step: None)
    try:
        world = RecordedWorld(recorded, log, on_arrival, scratch)
        try:
            return drive(world.rig)
        finally:
            world.close()
    finally:
        recorded.close()


def _copy_truth(run: Path, out: Path) -> None:
    """Where a simulated rover stands, and what it has seen: a next run on that rig goes on from there."""
    for name in TRUTH_FILES:
        if (run / name).is_file():
            shutil.copyfile(run / name, out / name)


class Silence(Journal):
    """Takes what a run does and writes nothing down: it is in the log already."""

    def put_protobuf(self, topic: str, time: float, message: Message) -> None:
        """Nothing."""

    def put_json(self, topic: str, time: float, content: Mapping[str, Any], kind: type | None) -> None:
        """Nothing."""

    def put_bytes(self, topic: str, time: float, data: bytes) -> None:
        """Nothing."""
