"""What a run was made from, written into its log and read back from it, so that it can be replayed without anything
else: mission file, camera, model, seed, wire, versions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import rover_protocol.messages as messages

import rover
from rover.errors import BadInput
from rover.link.handshake import Identity
from rover.mission.config import Mission, from_document
from rover.mission.former_run import FILES as FORMER_FILES
from rover.mission.former_run import FormerRun, load_run
from rover.record.recording import Recording
from rover.report.result import Identities
from rover.toml_file import read_toml
from rover.vision.camera.file import camera_file
from rover.vision.camera.model import CameraModel

MISSION_FILE = "mission.toml"
CAMERA_FILE = "camera.toml"
MODEL_FILE = "model.onnx"
VEHICLE_FILE = "vehicle.toml"
WORLD_FILE = "world.toml"
# Before the names of files of the run that this one is the second visit after.
EARLIER = "earlier_"
TOML = "application/toml"
BINARY = "application/octet-stream"
SOURCES = Path(rover.__file__).resolve().parent


def origin_of(mission: Mission, rig: str, transport: str, seed: int, cycle: float, model_hash: str) -> dict[str, str]:
    """What identifies a run; nothing in it varies between two runs of the same seed on the same build."""
    return {
        "mission": mission.name,
        "seed": str(seed),
        "rig": rig,
        "transport": transport,
        "baud": str(mission.rover.baud),
        "cycle_s": f"{cycle:g}",
        "rover_version": rover.__version__,
        "source_hash": source_hash(),
        "schema_hash": f"{messages.SCHEMA_HASH:08x}",
        "model_hash": model_hash,
        "mission_hash": hashlib.sha256(mission.path.read_bytes()).hexdigest(),
        "camera": Path(mission.rover.camera).name,
    }


def session_of(origin: Mapping[str, str]) -> int:
    """The number that the firmware knew a logged mission by."""
    return int(origin["session"]) if "session" in origin else int(origin["seed"]) & 0xFFFF


def identities_of(
    mission: Mission, rig: str, seed: int, model_hash: str, firmware: Identity | None, after: str = ""
) -> Identities:
    """What was at work, for the report; `firmware`: what it said of itself, None when it was never heard.

    `after`: name of the run that this one went on from.
    """
    known = Identities(
        rig=rig,
        seed=seed,
        rover_version=rover.__version__,
        schema_hash=f"{messages.SCHEMA_HASH:08x}",
        model_hash=model_hash[:12],
        mission_hash=_short_hash(mission.path),
        source_hash=source_hash(),
        camera=Path(mission.rover.camera).name,
        camera_hash=_short_hash(camera_file(mission.rover.camera)),
        vehicle_hash=_short_hash(Path(mission.rover.vehicle_file)) if mission.rover.vehicle_file else "standard",
        after=after,
    )
    if firmware is None:
        return known
    return replace(
        known,
        firmware_version=firmware.version,
        firmware_git_hash=firmware.git_hash,
        board=firmware.board,
    )


def _short_hash(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()[:12]


def attach_files(
    recording: Recording, mission: Mission, former: Path | None = None, earlier: Path | None = None
) -> None:
    """Mission and camera; vehicle, world, model that do not ship with the project; files of the run gone on from.

    earlier: the run that this one is the second visit after.
    """
    recording.attach(MISSION_FILE, TOML, mission.path.read_bytes())
    recording.attach(CAMERA_FILE, TOML, camera_file(mission.rover.camera).read_bytes())
    if mission.rover.vehicle_file:
        recording.attach(VEHICLE_FILE, TOML, Path(mission.rover.vehicle_file).read_bytes())
    if mission.field.world.endswith(".toml"):
        recording.attach(WORLD_FILE, TOML, Path(mission.field.world).read_bytes())
    if mission.detector.model:
        recording.attach(MODEL_FILE, BINARY, Path(mission.detector.model).read_bytes())
    if former is not None:
        for name in FORMER_FILES:
            recording.attach(name, BINARY, (former / name).read_bytes())
    if earlier is not None:
        for name in FORMER_FILES:
            recording.attach(EARLIER + name, BINARY, (earlier / name).read_bytes())


def restore_former(files: Mapping[str, bytes], folder: Path, mission: Mission, camera: CameraModel) -> FormerRun | None:
    """The earlier run that a log's run went on from, laid into `folder`; None when it began anew. Raises BadInput."""
    if not all(name in files for name in FORMER_FILES):
        return None
    for name in FORMER_FILES:
        (folder / name).write_bytes(files[name])
    return load_run(folder, mission, camera)


def restore_earlier(
    files: Mapping[str, bytes], folder: Path, mission: Mission, camera: CameraModel, name: str
) -> FormerRun | None:
    """The run after which a log's run was the second visit, laid into `folder`/`name`; None: there was none."""
    if not all(EARLIER + file in files for file in FORMER_FILES):
        return None
    place = folder / (name or "earlier")
    place.mkdir(exist_ok=True)
    for file in FORMER_FILES:
        (place / file).write_bytes(files[EARLIER + file])
    return load_run(place, mission, camera)


def restore_mission(files: Mapping[str, bytes], folder: Path, overrides: Mapping[str, Any]) -> Mission:
    """The mission of a log's attachments, laid into `folder`.

    `overrides`: "section.key" to a value of the mission file.

    Raises BadInput when the log holds no mission, or an override does not fit.
    """
    for name in (MISSION_FILE, CAMERA_FILE):
        if name not in files:
            raise BadInput(f"the log holds no {name}: it was not recorded by a mission of this version")
    for name in (MISSION_FILE, CAMERA_FILE, VEHICLE_FILE, WORLD_FILE, MODEL_FILE):
        if name in files:
            (folder / name).write_bytes(files[name])
    path = folder / MISSION_FILE
    document = read_toml(path)
    document.setdefault("rover", {})["camera"] = CAMERA_FILE
    if VEHICLE_FILE in files:
        document["rover"]["vehicle"] = VEHICLE_FILE
    if WORLD_FILE in files:
        document["field"]["world"] = WORLD_FILE
    if MODEL_FILE in files:
        document.setdefault("detector", {})["model"] = MODEL_FILE
    for key, value in overrides.items():
        section, _, name = key.partition(".")
        if not name:
            raise BadInput(f"--override {key}: SECTION.KEY of the mission file is expected, as detector.standoff_m")
        document.setdefault(section, {})[name] = value
    return from_document(document, path)


def source_hash() -> str:
    """SHA-256 over the companion's sources, 12 digits: a work tree may differ from the commit that it began as."""
    digest = hashlib.sha256()
    for file in sorted(SOURCES.rglob("*.py"), key=lambda file: file.relative_to(SOURCES).as_posix()):
        digest.update(file.relative_to(SOURCES).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:12]
