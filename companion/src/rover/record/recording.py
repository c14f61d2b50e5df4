"""The log of a run: MCAP, with Foxglove's schemas where they fit and JSON with a schema for the rest.

All times are mission time, so the same mission with the same seed gives the same bytes. Chunks are small and are
handed to the system every two seconds at most: what a dying process leaves is readable up to its last chunk.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, get_type_hints

import numpy as np
from foxglove_schemas_protobuf.Grid_pb2 import Grid
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import register_schema
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2

LIBRARY = "rover"
CHUNK_SIZE = 96 * 1024
"""Two thermal pictures of 160×120 with the telemetry between them."""

FLUSH_PERIOD = 2.0
LOG_LEVELS = {"debug": Log.DEBUG, "info": Log.INFO, "warning": Log.WARNING, "error": Log.ERROR, "fatal": Log.FATAL}
JSON_TYPES: dict[Any, str] = {float: "number", int: "integer", str: "string", bool: "boolean"}


class Recording:
    """Writes one MCAP file; use it as a context manager. Times are seconds of the mission's clock."""

    def __init__(self, path: Path, metadata: Mapping[str, str] | None = None) -> None:
        """`metadata`: what identifies the run (mission, seed, versions); no wall-clock times, please."""
        self._stream = path.open("wb")
        self._writer = Writer(self._stream, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library=LIBRARY)
        if metadata:
            self._writer.add_metadata("mission", {key: metadata[key] for key in sorted(metadata)})
        self._stream.flush()
        self._channels: dict[str, int] = {}
        self._sequences: dict[str, int] = {}
        self._flush_due = FLUSH_PERIOD
        self._open = True

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Writes index and footer. May be called twice."""
        if self._open:
            self._open = False
            self._writer.finish()
            self._stream.close()

    def frame(self, time: float, frame: Frame, topic: str = "/camera/thermal") -> None:
        """A thermal picture, delivered at `time`: 16 bits, kelvin × 100, stamped with its exposure."""
        width, height = frame.size
        image = RawImage(
            timestamp=_stamp(frame.time),
            frame_id="camera_optical",
            width=width,
            height=height,
            encoding="mono16",
            step=2 * width,
            data=np.ascontiguousarray(frame.counts, dtype="<u2").tobytes(),
        )
        self._protobuf(topic, time, image)

    def pose(self, time: float, pose: Pose2, topic: str = "/pose", frame_id: str = "map") -> None:
        """Where base_link is in map."""
        self._protobuf(topic, time, PoseInFrame(timestamp=_stamp(time), frame_id=frame_id, pose=_pose(pose)))

    def path(self, time: float, points: NDArray[np.float64], topic: str = "/plan/path") -> None:
        """A planned path, (N, 2) in map."""
        poses = [_pose(Pose2(x, y, 0.0)) for x, y in np.asarray(points, dtype=np.float64).reshape(-1, 2).tolist()]
        self._protobuf(topic, time, PosesInFrame(timestamp=_stamp(time), frame_id="map", poses=poses))

    def grid(
        self, time: float, cells: NDArray[Any], origin: tuple[float, float], resolution: float, topic: str = "/map/grid"
    ) -> None:
        """A raster (h, w) of map, row 0 at the bottom: float32, or what uint8 holds."""
        floating = np.issubdtype(cells.dtype, np.floating)
        data = np.ascontiguousarray(cells, dtype="<f4" if floating else np.uint8)
        size = data.dtype.itemsize
        kind = PackedElementField.FLOAT32 if floating else PackedElementField.UINT8
        grid = Grid(timestamp=_stamp(time), frame_id="map", pose=_pose(Pose2(*origin, 0.0)))
        grid.column_count = data.shape[1]
        grid.cell_size.x = grid.cell_size.y = resolution
        grid.row_stride = data.shape[1] * size
        grid.cell_stride = size
        grid.fields.append(PackedElementField(name="value", offset=0, type=kind))
        grid.data = data.tobytes()
        self._protobuf(topic, time, grid)

    def log(self, time: float, level: str, text: str, name: str = "mission", topic: str = "/log") -> None:
        """A line of text; levels: debug, info, warning, error, fatal."""
        self._protobuf(topic, time, Log(timestamp=_stamp(time), level=LOG_LEVELS[level], message=text, name=name))

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
        channel = self._channels.get(topic)
        if channel is None:
            name = f"rover.{schema.__name__}" if schema else f"rover{topic.replace('/', '.')}"
            text = json.dumps(json_schema(name, schema), separators=(",", ":"))
            identifier = self._writer.register_schema(name, "jsonschema", text.encode())
            channel = self._channels[topic] = self._writer.register_channel(topic, "json", identifier)
        self._add(topic, channel, time, to_json(content).encode())

    def telemetry(self, time: float, event: object) -> None:
        """Telemetry of the link under `/telemetry/` and its name."""
        self.event(f"/telemetry/{type(event).__name__}", time, event)

    def _protobuf(self, topic: str, time: float, message: Message) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            schema = register_schema(self._writer, type(message))
            channel = self._channels[topic] = self._writer.register_channel(topic, "protobuf", schema)
        self._add(topic, channel, time, message.SerializeToString(deterministic=True))

    def _add(self, topic: str, channel: int, time: float, data: bytes) -> None:
        sequence = self._sequences.get(topic, 0)
        self._sequences[topic] = sequence + 1
        stamp = round(time * 1e9)
        self._writer.add_message(channel, stamp, data, stamp, sequence & 0xFFFF_FFFF)
        if time >= self._flush_due:
            self._stream.flush()
            self._flush_due = time + FLUSH_PERIOD


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


def _stamp(time: float) -> Timestamp:
    nanoseconds = round(time * 1e9)
    return Timestamp(seconds=nanoseconds // 1_000_000_000, nanos=nanoseconds % 1_000_000_000)


def _pose(pose: Pose2) -> Pose:
    message = Pose()
    message.position.x, message.position.y = pose.x, pose.y
    message.orientation.z, message.orientation.w = np.sin(0.5 * pose.heading), np.cos(0.5 * pose.heading)
    return message
