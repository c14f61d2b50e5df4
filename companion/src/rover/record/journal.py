"""What a run writes down, message by message: Foxglove's schemas where they fit, JSON with a schema for the rest.

A `Journal` only makes the messages. `Recording` writes them to a file, `rover.record.comparison` holds them against
those of a file: so a replay compares exactly what a run records.

Callers give mission time; stamps in messages are mission time after `epoch`, when the mission began.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, get_type_hints

import numpy as np
from foxglove_schemas_protobuf.Grid_pb2 import Grid
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.Vector2_pb2 import Vector2
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.link.intake import Cycle
from rover.record.device_cycle import pack_cycle
from rover.record.epoch import NO_EPOCH, Epoch
from rover.record.rig_step import pack_step
from rover.record.topics import CAMERA_FRAME, CAMERA_THERMAL, GRID, RIG_CYCLE, RIG_STEP

LOG_LEVELS = {"debug": Log.DEBUG, "info": Log.INFO, "warning": Log.WARNING, "error": Log.ERROR, "fatal": Log.FATAL}
JSON_TYPES: dict[Any, str] = {float: "number", int: "integer", str: "string", bool: "boolean"}


class Journal(ABC):
    """Makes messages of what a run does. Times are seconds of the mission's clock."""

    # Why nothing more is written down, None while all is well.
    failure: str | None = None

    # What the stamps of messages count from.
    epoch: Epoch = NO_EPOCH

    @abstractmethod
    def put_protobuf(self, topic: str, time: float, message: Message) -> None:
        """Takes a message of one of Foxglove's schemas."""

    @abstractmethod
    def put_json(self, topic: str, time: float, content: Mapping[str, Any], kind: type | None) -> None:
        """Takes a value of our own; `kind`: the dataclass that it was, None for a mapping."""

    @abstractmethod
    def put_bytes(self, topic: str, time: float, data: bytes) -> None:
        """Takes bytes of a layout of our own."""

    def frame(self, time: float, frame: Frame, topic: str = CAMERA_THERMAL) -> None:
        """A thermal picture, delivered at `time`: 16 bits, kelvin × 100, stamped with its exposure (whole µs)."""
        width, height = frame.size
        image = RawImage(
            timestamp=self._stamp(frame.time),
            frame_id="camera_optical",
            width=width,
            height=height,
            encoding="mono16",
            step=2 * width,
            data=np.ascontiguousarray(frame.counts, dtype="<u2").tobytes(),
        )
        exposure_us = round(frame.time * 1e6)
        self.event(CAMERA_FRAME, time, {"sequence": frame.sequence, "exposure_us": exposure_us, "ffc": frame.ffc})
        self.put_protobuf(topic, time, image)

    def step(self, now_us: int, ticks: bytes, to_firmware: bytes, from_firmware: bytes) -> None:
        """What entered and left a simulated rig's firmware until `now_us`; layout: see rover.record.rig_step."""
        self.put_bytes(RIG_STEP, now_us * 1e-6, pack_step(now_us, ticks, to_firmware, from_firmware))

    def cycle(self, cycle: Cycle) -> None:
        """What came in from a real rover in one cycle."""
        self.put_bytes(RIG_CYCLE, cycle.time, pack_cycle(cycle))

    def pose(self, time: float, pose: Pose2, topic: str = "/pose", frame_id: str = "map") -> None:
        """Where base_link is in map."""
        self.put_protobuf(topic, time, PoseInFrame(timestamp=self._stamp(time), frame_id=frame_id, pose=_pose(pose)))

    def path(self, time: float, points: NDArray[np.float64], topic: str = "/plan/path") -> None:
        """A planned path, (N, 2) in map."""
        poses = [_pose(Pose2(x, y, 0.0)) for x, y in np.asarray(points, dtype=np.float64).reshape(-1, 2).tolist()]
        self.put_protobuf(topic, time, PosesInFrame(timestamp=self._stamp(time), frame_id="map", poses=poses))

    def grid(self, time: float, seen: NDArray[np.bool_], occupied: NDArray[np.bool_], resolution: float) -> None:
        """The map, (rows, columns) with row 0 at y = 0: -1 unknown, 0 free, 100 occupied, as in nav_msgs."""
        cells = np.where(occupied, 100, np.where(seen, 0, -1)).astype(np.int8)
        columns = cells.shape[1]
        message = Grid(
            timestamp=self._stamp(time),
            frame_id="map",
            pose=_pose(Pose2(0.0, 0.0, 0.0)),
            column_count=columns,
            cell_size=Vector2(x=resolution, y=resolution),
            row_stride=columns,
            cell_stride=1,
            fields=[PackedElementField(name="occupancy", offset=0, type=PackedElementField.INT8)],
            data=cells.tobytes(),
        )
        self.put_protobuf(GRID, time, message)

    def log(self, time: float, level: str, text: str, name: str = "mission", topic: str = "/log") -> None:
        """A line of text; levels: debug, info, warning, error, fatal."""
        self.put_protobuf(
            topic, time, Log(timestamp=self._stamp(time), level=LOG_LEVELS[level], message=text, name=name)
        )

    def link(self, direction: str, time: float, identifier: int, payload: bytes) -> None:
        """A frame of the link, "rx" or "tx", as it travelled; fits as the tap of `rover.link.session.Link`."""
        self.event(f"/link/{direction}", time, {"id": identifier, "data": payload.hex()})

    def event(self, topic: str, time: float, value: object) -> None:
        """One of our own values as JSON: a dataclass (its schema is written once) or a mapping."""
        if is_dataclass(value) and not isinstance(value, type):
            content = {entry.name: getattr(value, entry.name) for entry in fields(value)}
            schema = type(value)
        elif isinstance(value, Mapping):
            content, schema = dict(value), None
        else:
            raise TypeError(f"{topic}: a dataclass or a mapping is needed, not {type(value).__name__}")
        self.put_json(topic, time, content, schema)

    def telemetry(self, time: float, event: object) -> None:
        """Telemetry of the link under `/telemetry/` and its name."""
        self.event(f"/telemetry/{type(event).__name__}", time, event)

    def _stamp(self, time: float) -> Timestamp:
        nanoseconds = self.epoch.utc_ns + round(time * 1e9)
        return Timestamp(seconds=nanoseconds // 1_000_000_000, nanos=nanoseconds % 1_000_000_000)


def to_json(content: object) -> str:
    """Strict JSON on one line; a number that is not finite becomes null, for JSON has none."""
    try:
        return json.dumps(content, separators=(",", ":"), default=_plain, ensure_ascii=False, allow_nan=False)
    except ValueError:
        lenient = json.dumps(content, default=_plain, ensure_ascii=False)
        finite = json.loads(lenient, parse_constant=lambda _: None)
        return json.dumps(finite, separators=(",", ":"), ensure_ascii=False)


def json_schema(name: str, kind: type | None) -> dict[str, Any]:
    """JSON Schema of a dataclass of plain fields; of any object for None."""
    schema: dict[str, Any] = {"title": name, "type": "object"}
    if kind is not None:
        hints = get_type_hints(kind)
        properties = {}
        for entry in fields(kind):
            known = JSON_TYPES.get(hints[entry.name])
            properties[entry.name] = {"type": known} if known else {}
        schema["properties"] = properties
    return schema


def _plain(value: object) -> object:
    """What JSON does not know by itself."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, bytes):
        return value.hex()
    if is_dataclass(value) and not isinstance(value, type):
        return {entry.name: getattr(value, entry.name) for entry in fields(value)}
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _pose(pose: Pose2) -> Pose:
    message = Pose()
    message.position.x, message.position.y = pose.x, pose.y
    message.orientation.z, message.orientation.w = np.sin(0.5 * pose.heading), np.cos(0.5 * pose.heading)
    return message
