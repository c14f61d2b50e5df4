"""A run's log as the page's time slider wants it: poses, plans, places, maps, events, signals and pictures by time."""

from __future__ import annotations

import json
import math
import threading
from bisect import bisect_right
from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.Grid_pb2 import Grid
from foxglove_schemas_protobuf.Log_pb2 import Log as LogLine
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from rover.console.runs import LOG
from rover.console.sessions import Refused
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission.moment import OBSTACLES, SEEN, SEEN_ALPHA, encoded, seen_places, stretched, tinted
from rover.mission.origin import CAMERA_FILE
from rover.record.log_reader import Log, LogMessage
from rover.record.strict_json import finite
from rover.record.topics import CAMERA_FRAME, CAMERA_THERMAL, GRID, PLACES, POSE
from rover.report.map_plot import png_bytes
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

PLAN, EVENTS = "/plan/path", "/log"
BATTERY, VELOCITY = "/telemetry/Battery", "/telemetry/Velocity"
OCCUPIED = 100
TOPICS = (POSE, PLAN, EVENTS, PLACES, GRID, CAMERA_FRAME, CAMERA_THERMAL, BATTERY, VELOCITY)
MAX_POINTS = 4000
# Pictures kept of one run, evenly apart; those of so many runs.
MAX_PICTURES = 800
MAX_RUNS = 2
# Pictures shown of one indication.
VIEWS = 8


@dataclass
class Replay:
    """What one log tells. Times in seconds of the mission; poses are t, x, y, heading."""

    camera: CameraModel | None = None
    poses: list[tuple[float, float, float, float]] = field(default_factory=list)
    plans: list[dict[str, Any]] = field(default_factory=list)
    places: list[dict[str, Any]] = field(default_factory=list)
    maps: list[dict[str, Any]] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)
    battery: list[tuple[float, float]] = field(default_factory=list)
    speed: list[tuple[float, float]] = field(default_factory=list)
    pictures: list[tuple[float, bytes]] = field(default_factory=list)
    _exposed: float = 0.0
    _every: int = 1
    _came: int = 0

    def take(self, message: LogMessage) -> None:
        """One message of the log, in order."""
        time = message.time_ns * 1e-9
        if message.topic == POSE:
            pose = PoseInFrame.FromString(message.data).pose
            heading = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
            self.poses.append((time, pose.position.x, pose.position.y, heading))
        elif message.topic == PLAN:
            poses = PosesInFrame.FromString(message.data).poses
            self.plans.append({"t": time, "points": [[p.position.x, p.position.y] for p in poses]})
        elif message.topic == PLACES:
            self.places.append({"t": time, "places": json.loads(message.data)["places"]})
        elif message.topic == EVENTS:
            self.events.append({"t": time, "text": LogLine.FromString(message.data).message})
        elif message.topic == BATTERY:
            self.battery.append((time, json.loads(message.data)["voltage"]))
        elif message.topic == VELOCITY:
            self.speed.append((time, json.loads(message.data)["measured_travel"]))
        elif message.topic == GRID:
            self.maps.append({"t": time, **_map(Grid.FromString(message.data))})
        elif message.topic == CAMERA_FRAME:
            self._exposed = json.loads(message.data)["exposure_us"] * 1e-6
        elif message.topic == CAMERA_THERMAL:
            self._picture(RawImage.FromString(message.data))

    def document(self) -> dict[str, Any]:
        """All of it but the pictures."""
        told = {
            "poses": _thinned(self.poses),
            "plans": self.plans[-MAX_POINTS:],
            "places": self.places[-MAX_POINTS:],
            "maps": self.maps,
            "events": self.events[-MAX_POINTS:],
            "battery": _thinned(self.battery),
            "speed": _thinned(self.speed),
            "pictures": [time for time, _ in self.pictures],
        }
        rounded: dict[str, Any] = finite(told)
        return rounded

    def views(self, place: int, x: float, y: float) -> list[dict[str, Any]]:
        """Pictures in which a place of the map lies, evenly over the time, and where."""
        if self.camera is None or not self.poses:
            return []
        times = [pose[0] for pose in self.poses]
        found = []
        for number, (time, _) in enumerate(self.pictures):
            _, px, py, heading = self.poses[max(bisect_right(times, time) - 1, 0)]
            for _, u, v in seen_places(Pose2(px, py, heading), self.camera, {place: (x, y)}):
                found.append({"picture": number, "t": time, "u": u, "v": v})
        step = max(1, math.ceil(len(found) / VIEWS))
        return found[::step]

    def _picture(self, image: RawImage) -> None:
        self._came += 1
        if (self._came - 1) % self._every:
            return
        counts = np.frombuffer(image.data, "<u2").reshape(image.height, image.width)
        self.pictures.append((self._exposed, png_bytes(stretched(counts)[0])))
        if len(self.pictures) > MAX_PICTURES:
            self.pictures, self._every = self.pictures[::2], 2 * self._every


class Replays:
    """Those of the runs that were asked for last."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: OrderedDict[tuple[str, int], Replay] = OrderedDict()

    def of(self, folder: Path) -> Replay:
        """Reads the log, or what was read of it before. Raises Refused when there is none."""
        path = folder / LOG
        try:
            key = (folder.name, path.stat().st_mtime_ns)
        except OSError:
            raise Refused("this run has no log", 404) from None
        with self._lock:
            if key not in self._known:
                self._known[key] = _read(path)
            self._known.move_to_end(key)
            while len(self._known) > MAX_RUNS:
                self._known.popitem(last=False)
            return self._known[key]


def _read(path: Path) -> Replay:
    try:
        log = Log(path)
        replay = Replay(camera=_camera(log))
        for message in log.messages(TOPICS):
            replay.take(message)
    except (BadInput, ValueError, KeyError) as error:
        raise Refused(str(error).replace(f"{path.parent}/", ""), 422) from None
    return replay


def _camera(log: Log) -> CameraModel | None:
    if CAMERA_FILE not in log.files:
        return None
    with TemporaryDirectory(prefix="rover-console-") as folder:
        file = Path(folder) / CAMERA_FILE
        file.write_bytes(log.files[CAMERA_FILE])
        return load_camera(file)


def _map(grid: Grid) -> dict[str, Any]:
    cells = np.frombuffer(grid.data, np.int8).reshape(-1, grid.column_count)[::-1]
    size = grid.cell_size
    return {
        "width_m": cells.shape[1] * size.x,
        "height_m": cells.shape[0] * size.y,
        "seen": encoded(tinted(cells >= 0, SEEN, SEEN_ALPHA)),
        "obstacles": encoded(tinted(cells == OCCUPIED, OBSTACLES, 255)),
    }


def _thinned(points: list[Any]) -> list[Any]:
    return points[:: max(1, math.ceil(len(points) / MAX_POINTS))]
