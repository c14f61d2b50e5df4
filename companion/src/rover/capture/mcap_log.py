"""Frames from the log of a run, as `rover run` and Foxglove write it: MCAP with pictures of 16 bits (mono16)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.exceptions import McapError
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import register
from rover.errors import BadInput

TOPIC = "/camera/thermal"
SCHEMA = "foxglove.RawImage"
MAX_RECORD_BYTES = 512 * 2**20
# What mcap and the decompressors raise where a file is cut or its bits are flipped; lz4 raises RuntimeError.
DAMAGED = (McapError, ZstdError, struct.error, ValueError, EOFError, MemoryError, OverflowError, RuntimeError)


@register("mcap")
class McapSource:
    """`mcap:FILE[?topic=/camera/thermal][&unit=centikelvin|raw]`: its foxglove.RawImage messages of mono16.

    The log holds no state of the shutter: a picture that repeats the one before counts as taken behind it.
    A log that is cut or damaged gives what stands before (`cut` is true then); chunks may be plain, zstd or lz4.
    Raises BadInput for a file that is missing, no MCAP, or without a picture on such a topic.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("topic", "unit"))
        self.file = Path(parsed.place)
        self.topic = parsed.options.get("topic", TOPIC)
        self._unit = parsed.unit("centikelvin")
        self.cut = False
        if not self.file.is_file():
            raise BadInput(f"{self.file}: no such log")

    def __iter__(self) -> Iterator[Frame]:
        from google.protobuf.message import DecodeError

        frozen = FrozenPicture()
        found = False
        try:
            for sequence, data in self._messages():
                image = RawImage.FromString(data)
                if image.encoding != "mono16" or len(image.data) < image.step * image.height or image.step % 2:
                    raise BadInput(f"{self.file}: {self.topic}: a picture that is not mono16")
                rows = np.frombuffer(image.data, "<u2", image.step * image.height // 2).reshape(image.height, -1)
                counts = rows[:, : image.width].astype(np.uint16)
                at = image.timestamp.seconds + image.timestamp.nanos * 1e-9
                found = True
                yield Frame(counts, at, sequence, frozen.repeats(counts), kelvin_per_count=self._unit)
        except BadInput:
            raise
        except (DecodeError, ValueError) as error:
            raise BadInput(f"{self.file}: {self.topic}: damaged ({type(error).__name__})") from error
        if not found:
            why = ", which is damaged or cut" if self.cut else ""
            raise BadInput(f"{self.file}: no pictures on {self.topic} in this log{why}")

    def _messages(self) -> Iterator[tuple[int, bytes]]:
        """Sequence and content in the order of writing, up to where the file ends or is damaged (`cut`)."""
        names: dict[int, str] = {}
        channels: set[int] = set()
        begun = False
        try:
            with self.file.open("rb") as stream:
                for record in StreamReader(stream, validate_crcs=True, record_size_limit=MAX_RECORD_BYTES).records:
                    begun = True
                    if isinstance(record, Schema):
                        names[record.id] = record.name
                    elif isinstance(record, Channel) and record.topic == self.topic:
                        if names.get(record.schema_id) != SCHEMA:
                            held = names.get(record.schema_id, "no")
                            raise BadInput(f"{self.file}: {self.topic} holds {held}, not {SCHEMA}")
                        channels.add(record.id)
                    elif isinstance(record, Message) and record.channel_id in channels:
                        yield record.sequence, record.data
        except BadInput:
            raise
        except DAMAGED as error:
            if not begun:
                raise BadInput(f"{self.file}: not an MCAP log, or damaged ({type(error).__name__})") from error
            self.cut = True
