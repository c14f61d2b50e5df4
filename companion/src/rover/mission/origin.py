"""What a run was made from, written into its log and read back from it, so that it can be replayed without anything
else: mission file, camera, model, seed, wire, versions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import rover_protocol.messages as messages

import rover
from rover.errors import BadInput
from rover.mission.config import Mission, from_document
from rover.record.recording import Recording
from rover.toml_file import read_toml
from rover.vision.camera_file import camera_file

MISSION_FILE = "mission.toml"
CAMERA_FILE = "camera.toml"
MODEL_FILE = "model.onnx"
TOML = "application/toml"
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


def attach_files(recording: Recording, mission: Mission) -> None:
    """Mission, camera and, where it is not the one that ships, the model."""
    recording.attach(MISSION_FILE, TOML, mission.path.read_bytes())
    recording.attach(CAMERA_FILE, TOML, camera_file(mission.rover.camera).read_bytes())
    if mission.detector.model:
        recording.attach(MODEL_FILE, "application/octet-stream", Path(mission.detector.model).read_bytes())


def restore_mission(files: Mapping[str, bytes], folder: Path, overrides: Mapping[str, Any]) -> Mission:
    """The mission of a log's attachments, laid into `folder`.

    `overrides`: "section.key" to a value of the mission file.

    Raises BadInput when the log holds no mission, or an override does not fit.
    """
    for name in (MISSION_FILE, CAMERA_FILE):
        if name not in files:
            raise BadInput(f"the log holds no {name}: it was not recorded by a mission of this version")
    for name in (MISSION_FILE, CAMERA_FILE, MODEL_FILE):
        if name in files:
            (folder / name).write_bytes(files[name])
    path = folder / MISSION_FILE
    document = read_toml(path)
    document.setdefault("rover", {})["camera"] = CAMERA_FILE
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
