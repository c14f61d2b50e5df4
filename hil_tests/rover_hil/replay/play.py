"""One replay: a log through the firmware of a rig and through the companion, both held against what was recorded."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import cv2
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput, RoverError
from rover.mission.begin import begin
from rover.mission.loop import Control, MissionLoop
from rover.mission.origin import origin_of, restore_earlier, restore_former, restore_mission, session_of
from rover.mission.run import DEVICE
from rover.record.comparison import Comparison, Differs, RecordingOver
from rover.record.difference import Difference
from rover.record.log_reader import Log
from rover.record.rig_step import RigStep
from rover.vision.camera.file import load_camera

from rover_hil.firmware_process import emulator_command, sitl_command
from rover_hil.parameter_file import settings_of, write_parameter_file
from rover_hil.replay.device import DeviceReplay
from rover_hil.replay.estimators import IMPORTED, replay_estimators
from rover_hil.replay.firmware import Compared, FirmwareReplay
from rover_hil.replay.pace import Pace
from rover_hil.replay.recorded_device import RecordedDevice
from rover_hil.replay.recorded_rig import RecordedOperator, RecordedRig, RecordedWorld

# Parts of a log's origin that are the run's, not the build's.
NOT_BUILD = ("mission", "seed", "rig", "transport", "baud", "cycle_s", "camera", "mission_hash")


@dataclass(frozen=True)
class Changes:
    """What is to be different from the recording: firmware parameters by number, values of the mission file."""

    parameters: Mapping[int, int] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Replayed:
    """What came of a replay. `build`: what is not as it was when the log was recorded, as "recorded → now".

    `cut`: the log's end is missing.
    """

    log: Path
    rig: str
    frames: int
    firmware: Compared | None
    companion: Compared
    build: dict[str, str]
    cut: bool = False

    @property
    def first_difference(self) -> Difference | None:
        """The earliest."""
        parts = [part for part in (self.firmware, self.companion) if part is not None]
        found = [part.difference for part in parts if part.difference is not None]
        return min(found, key=lambda difference: difference.time, default=None)

    @property
    def identical(self) -> bool:
        """True when every output is equal to the recorded one."""
        return self.first_difference is None


class FirmwarePart(Protocol):
    """Takes steps, says at the end what came of them."""

    def feed(self, step: RigStep) -> None:
        """The next step."""
        ...

    @property
    def identity(self) -> dict[str, str]:
        """Version, commit and board of the firmware; empty when it was not asked."""
        ...

    def finish(self) -> Compared:
        """After the last step."""
        ...


def replay(
    path: Path,
    rig: str,
    changes: Changes,
    pace: Pace,
    on_time: Callable[[float], None] = lambda _: None,
    port: str | None = None,
) -> Replayed:
    """`rig`: "sitl", "emulator" or "device" on `port`. `on_time` is told how far it is, seconds.

    Raises BadInput, PreflightFailed, LinkLost.
    """
    log = Log(path)
    origin = log.metadata.get("mission")
    if origin is None or "source_hash" not in origin:
        raise BadInput(f"{path}: the log does not say what it was made from: record it anew with this version")
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory(prefix="rover-replay-") as folder:
        scratch = Path(folder)
        mission = restore_mission(log.files, scratch, changes.overrides)
        classifier = Classifier(mission.detector.model or default_model())
        camera = load_camera(mission.rover.camera)
        seed = int(origin["seed"])
        session = session_of(origin)
        former = restore_former(log.files, scratch, mission, camera)
        earlier = restore_earlier(log.files, scratch, mission, camera, origin.get("visit_after", ""))
        survey = begin(mission, camera, classifier, seed, former, earlier)
        now = origin_of(mission, origin["rig"], origin["transport"], seed, float(origin["cycle_s"]), classifier.sha256)
        build = {
            key: f"{origin.get(key, 'unknown')} → {value}"
            for key, value in now.items()
            if key not in NOT_BUILD and origin.get(key) != value
        }
        comparison = Comparison(log)
        if origin["rig"] == IMPORTED:
            frames = replay_estimators(log, survey.perception, comparison, pace, on_time)
            return Replayed(
                path, rig, frames, None, Compared(comparison.messages, comparison.difference), build, log.cut
            )
        control = Control()
        operator = RecordedOperator(log, control)

        def on_arrival(now_us: int) -> None:
            pace.wait(now_us * 1e-6)
            on_time(now_us * 1e-6)
            operator.act(now_us)

        if origin["rig"] == DEVICE:
            if port is not None or changes.parameters:
                raise BadInput(f"{path}: recorded on a real rover: what entered its firmware is not in the log")
            device = RecordedDevice(log, on_arrival)
            _drive(MissionLoop(survey, device, comparison, None, control, session), comparison)
            companion = Compared(comparison.messages, comparison.difference)
            return Replayed(path, rig, device.frames_fed, None, companion, build, log.cut)
        part: FirmwarePart
        if port is None:
            part = _firmware_part(
                rig, origin, {**settings_of(mission.rover.vehicle), **changes.parameters}, scratch, log
            )
        elif changes.parameters:
            raise BadInput("--set: only on --rig sitl")
        else:
            part = _Nobody()
        recorded = RecordedRig(log, part.feed)
        try:
            world = RecordedWorld(recorded, log, on_arrival, scratch)
            try:
                _drive(MissionLoop(survey, world.rig, comparison, None, control, session), comparison)
            finally:
                world.close()
            recorded.drain()
        finally:
            recorded.close()
            firmware = part.finish()
            build |= _firmware_change(log.metadata.get("firmware", {}), part.identity)
        if port is not None:
            firmware = DeviceReplay(log, port).run(on_time)
        companion = Compared(comparison.messages, comparison.difference)
        return Replayed(path, rig, recorded.frames_fed, firmware, companion, build, log.cut)


class _Nobody:
    """In place of a firmware that does not go in lock step with the companion."""

    def feed(self, step: RigStep) -> None:
        """Nothing."""

    @property
    def identity(self) -> dict[str, str]:
        """Nothing is known."""
        return {}

    def finish(self) -> Compared:
        """Nothing was compared."""
        return Compared(0, None)


def _firmware_change(recorded: Mapping[str, str], now: Mapping[str, str]) -> dict[str, str]:
    """What the firmware says of itself otherwise than it did when the log was recorded."""
    return {
        f"firmware_{key}": f"{recorded.get(key, 'unknown')} → {value}"
        for key, value in now.items()
        if recorded.get(key) != value
    }


def _drive(loop: MissionLoop, comparison: Comparison) -> None:
    """The mission's loop until it ends as it did, or differs."""
    try:
        try:
            loop.drive()
        except RoverError as error:  # a handshake that fails ends a mission: it failed when it was recorded, too
            if comparison.difference is None and comparison.messages == 0:
                raise BadInput(f"the recorded link does not come up: {error}") from error
        comparison.finish()
    except (Differs, RecordingOver):
        return  # the difference is kept; a log that was cut ends where it was cut


def _firmware_part(
    rig: str, origin: dict[str, str], parameters: Mapping[int, int], scratch: Path, log: Log
) -> FirmwarePart:
    command = sitl_command() if rig == "sitl" else emulator_command()
    another = origin["rig"] != rig
    if another and origin["transport"] != "serial":
        raise BadInput(f"{log.path}: recorded over CAN on {origin['rig']}: only a log over serial goes to another rig")
    if parameters:
        if rig != "sitl":
            raise BadInput(f"--set: rig {rig} has no parameter file; set parameters on --rig sitl")
        file = scratch / "parameters.bin"
        write_parameter_file(command, file, dict(parameters))
        command = [*command, "--parameters", str(file)]
    return FirmwareReplay(command, origin, another)
