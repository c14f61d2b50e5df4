"""A folder of frames and CSV files, as a person records them with a real camera and real sensors, to a log.

frames.csv   time_s, file[, ffc]             16-bit pictures (PNG or TIFF) beside it or in sub-folders
wheels.csv   time_s, left_counts, right_counts
sonar.csv    time_s, sensor, range_m         may be left out; sensor left, centre, right; no range: no echo
mission.toml, camera.toml                    may be left out: 20 m x 20 m, launch in the middle; lepton-160
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import cv2
from rover.capture.frame import Frame
from rover.capture.picture import read_counts
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput
from rover.link.telemetry import SonarRange, WheelMotion
from rover.mission.config import Mission
from rover.mission.origin import CAMERA_FILE, MISSION_FILE, attach_files, origin_of, restore_mission
from rover.mission.perception import Perception
from rover.record.recording import Recording
from rover.vehicle import Vehicle
from rover.vision.camera.file import camera_file, load_camera

from rover_hil.replay.csv_table import read_csv
from rover_hil.replay.estimators import IMPORTED, Estimators, Input, write_input

DEFAULT_MISSION = b"""# A stream of a place that is not known.
[mission]
name = "imported"

[area]
width_m = 20.0
height_m = 20.0

[launch]
x_m = 10.0
y_m = 10.0
"""
DEFAULT_CAMERA = "lepton-160"
SENSORS = ("left", "centre", "right")
YES, NO = ("1", "true", "yes"), ("", "0", "false", "no")
# Of inputs at the same time: a frame is taken in when the wheels of its time are known.
RANK = {WheelMotion: 0, SonarRange: 1, Frame: 2}


def import_folder(folder: Path, out: Path) -> dict[str, int]:
    """Writes the log `out`: the inputs, and what the estimators make of them. Returns how many of each there were.

    Raises BadInput, naming file and line.
    """
    if not folder.is_dir():
        raise BadInput(f"--import {folder}: no such folder")
    cv2.setNumThreads(1)
    files = {MISSION_FILE: _content(folder / MISSION_FILE, DEFAULT_MISSION)}
    files[CAMERA_FILE] = _content(folder / CAMERA_FILE, camera_file(DEFAULT_CAMERA).read_bytes())
    with tempfile.TemporaryDirectory(prefix="rover-import-") as scratch:
        mission = restore_mission(files, Path(scratch), {})
        inputs = read_folder(folder, mission)
        classifier = Classifier(mission.detector.model or default_model())
        camera = load_camera(mission.rover.camera)
        perception = Perception(mission, Vehicle(), camera, classifier)
        origin = origin_of(mission, IMPORTED, "none", 0, 0.0, classifier.sha256)
        counts = {"frames": 0, "wheel reports": 0, "ranges": 0}
        names = {Frame: "frames", WheelMotion: "wheel reports", SonarRange: "ranges"}
        try:
            recording = Recording(out, origin)
        except OSError as error:
            raise BadInput(f"--out {out}: cannot be written: {error.strerror or error}") from error
        with recording:
            attach_files(recording, mission)
            estimators = Estimators(perception, recording)
            for now, value in inputs:
                write_input(recording, now, value)
                estimators.take(now, value)
                counts[names[type(value)]] += 1
    return counts


def read_folder(folder: Path, mission: Mission) -> list[Input]:
    """All inputs in the order in which they are taken in; times in whole µs from the first one on. Raises BadInput."""
    camera = load_camera(mission.rover.camera)
    wheels = list(_wheels(folder / "wheels.csv"))
    if not wheels:
        raise BadInput(f"{folder / 'wheels.csv'}: no rows: poses between frames come from the wheels")
    frames = list(_frames(folder, (camera.width, camera.height)))
    if not frames:
        raise BadInput(f"{folder / 'frames.csv'}: no rows")
    sonar = list(_sonar(folder / "sonar.csv")) if (folder / "sonar.csv").exists() else []
    origin = min(values[0].time for values in (wheels, frames, sonar) if values)
    shifted: list[Input] = []
    for wheel in wheels:
        at = _micro(wheel.time - origin)
        shifted.append((at, WheelMotion(at, wheel.left_counts, wheel.right_counts)))
    for ping in sonar:
        at = _micro(ping.time - origin)
        shifted.append((at, SonarRange(at, ping.sensor, ping.range_m, ping.status)))
    times = [_micro(wheel.time - origin) for wheel in wheels]
    later = 0
    for frame in frames:
        at = _micro(frame.time - origin)
        while later < len(times) and times[later] < at:
            later += 1
        taken = times[later] if later < len(times) else at
        shifted.append((taken, Frame(frame.counts, at, frame.sequence, frame.ffc)))
    return sorted(shifted, key=lambda entry: (entry[0], RANK[type(entry[1])]))


def _wheels(file: Path) -> Iterator[WheelMotion]:
    for row in read_csv(file, ("time_s", "left_counts", "right_counts")):
        yield WheelMotion(row.number("time_s"), row.whole("left_counts"), row.whole("right_counts"))


def _sonar(file: Path) -> Iterator[SonarRange]:
    for row in read_csv(file, ("time_s", "sensor", "range_m")):
        name = row.text("sensor")
        if name not in SENSORS:
            raise row.fail("sensor", f"one of {', '.join(SENSORS)} is expected")
        silent = not row.text("range_m")
        distance = None if silent else row.number("range_m")
        if distance is not None and distance <= 0.0:
            raise row.fail("range_m", "metres above 0 are expected, or nothing where no echo came")
        yield SonarRange(row.number("time_s"), SENSORS.index(name), distance, "NoEcho" if silent else "Ok")


def _frames(folder: Path, size: tuple[int, int]) -> Iterator[Frame]:
    for sequence, row in enumerate(read_csv(folder / "frames.csv", ("time_s", "file"), ("ffc",))):
        word = row.text("ffc").lower()
        if word not in (*YES, *NO):
            raise row.fail("ffc", "1 or 0 is expected")
        try:
            frame = Frame(read_counts(folder / row.text("file")), row.number("time_s"), sequence, word in YES)
        except BadInput as error:
            raise BadInput(f"{row.file}:{row.line}: {error}") from error
        if frame.size != size:
            is_, wanted = (f"{width}x{height}" for width, height in (frame.size, size))
            raise BadInput(f"{row.file}:{row.line}: {row.text('file')} is {is_} pixels, the camera has {wanted}")
        yield frame


def _micro(seconds: float) -> float:
    """Whole microseconds, as a log keeps them."""
    return round(seconds * 1e6) * 1e-6


def _content(file: Path, otherwise: bytes) -> bytes:
    return file.read_bytes() if file.is_file() else otherwise
