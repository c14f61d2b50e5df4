"""The log of a run as an MCAP file; what is in it is said by `rover.record.journal`.

Chunks are small and are handed to the system every two seconds at most: what a dying process leaves is readable up to
its last chunk.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

from google.protobuf.message import Message
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set, register_schema

from rover.errors import BadInput
from rover.record.epoch import NO_EPOCH, Epoch
from rover.record.foxglove_stream import FoxgloveStream
from rover.record.journal import Journal, json_schema, to_json

LIBRARY = "rover"
# Two thermal pictures of 160×120 with the telemetry between them.
CHUNK_SIZE = 96 * 1024

FLUSH_PERIOD = 2.0
NO_SCHEMA = 0
# Encoding of messages whose layout is said in rover.record.rig_step and rover.record.device_cycle.
BYTES = "rover-bytes"


class Recording(Journal):
    """Writes one MCAP file; use it as a context manager. Times are seconds of the mission's clock, in the file
    nanoseconds since 1970 where its `epoch` is known."""

    def __init__(
        self,
        path: Path,
        metadata: Mapping[str, str] | None = None,
        epoch: Epoch = NO_EPOCH,
        live: FoxgloveStream | None = None,
    ) -> None:
        """`metadata`: what identifies the run (mission, seed, versions). `epoch`: when mission time 0 was. `live`: is
        given every message, too.

        Raises BadInput where no file can be written at all.
        """
        try:
            self.epoch = epoch
            self._live = live
            self._stream = path.open("wb")
            self._writer = Writer(self._stream, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
            self._writer.start(profile="", library=LIBRARY)
            if metadata:
                self.identify("mission", metadata)
            if epoch != NO_EPOCH:
                self.identify("clock", epoch.metadata())
            self._stream.flush()
        except OSError as error:
            raise BadInput(f"{path}: the log cannot be written: {error.strerror or error}") from error
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
            with self._failing():
                self._writer.finish()
            with self._failing():
                self._stream.close()

    @contextmanager
    def _failing(self) -> Iterator[None]:
        """A disk that takes no more costs the rest of the log, not the mission."""
        try:
            yield
        except OSError as error:
            self.failure = self.failure or f"the log can no longer be written: {error.strerror or error}"

    def identify(self, name: str, values: Mapping[str, str]) -> None:
        """A record of metadata: who was at work."""
        with self._failing():
            self._writer.add_metadata(name, {key: values[key] for key in sorted(values)})

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        """A whole file that the run was made from."""
        with self._failing():
            self._writer.add_attachment(self.epoch.utc_ns, self.epoch.utc_ns, name, media_type, content)

    def put_protobuf(self, topic: str, time: float, message: Message) -> None:
        """See Journal."""
        channel = self._channels.get(topic)
        if channel is None:
            schema = register_schema(self._writer, type(message))
            channel = self._channels[topic] = self._writer.register_channel(topic, "protobuf", schema)
            if self._live is not None:
                described = build_file_descriptor_set(type(message)).SerializeToString()
                self._live.open(topic, "protobuf", (message.DESCRIPTOR.full_name, "protobuf", described))
        self._add(topic, channel, time, message.SerializeToString(deterministic=True))

    def put_json(self, topic: str, time: float, content: Mapping[str, Any], kind: type | None) -> None:
        """See Journal; the schema is written once."""
        channel = self._channels.get(topic)
        if channel is None:
            name = f"rover.{kind.__name__}" if kind else f"rover{topic.replace('/', '.')}"
            text = json.dumps(json_schema(name, kind), separators=(",", ":"))
            identifier = self._writer.register_schema(name, "jsonschema", text.encode())
            channel = self._channels[topic] = self._writer.register_channel(topic, "json", identifier)
            if self._live is not None:
                self._live.open(topic, "json", (name, "jsonschema", text.encode()))
        self._add(topic, channel, time, to_json(content).encode())

    def put_bytes(self, topic: str, time: float, data: bytes) -> None:
        """See Journal."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._writer.register_channel(topic, BYTES, NO_SCHEMA)
            if self._live is not None:
                self._live.open(topic, BYTES, None)
        self._add(topic, channel, time, data)

    def _add(self, topic: str, channel: int, time: float, data: bytes) -> None:
        if self.failure is not None:
            return
        sequence = self._sequences.get(topic, 0)
        self._sequences[topic] = sequence + 1
        stamp = self.epoch.utc_ns + round(time * 1e9)
        if self._live is not None:
            self._live.publish(topic, stamp, data)
        with self._failing():
            self._writer.add_message(channel, stamp, data, stamp, sequence & 0xFFFF_FFFF)
            if time >= self._flush_due:
                self._stream.flush()
                self._flush_due = time + FLUSH_PERIOD
