"""Frames from the log of a run, as `rover run` and Foxglove write it: MCAP with pictures of 16 bits (mono16)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import register
from rover.errors import BadInput

TOPIC = "/camera/thermal"
SCHEMA = "foxglove.RawImage"


@register("mcap")
class McapSource:
    """`mcap:FILE[?topic=/camera/thermal][&unit=centikelvin|raw]`: its foxglove.RawImage messages of mono16.

    The log holds no state of the shutter: a picture that repeats the one before counts as taken behind it.
    Raises BadInput for a file that is missing, no MCAP, damaged, or without such a topic.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("topic", "unit"))
        self.file = Path(parsed.place)
        self.topic = parsed.options.get("topic", TOPIC)
        self._unit = parsed.unit("centikelvin")
        if not self.file.is_file():
            raise BadInput(f"{self.file}: no such log")

    def __iter__(self) -> Iterator[Frame]:
        from google.protobuf.message import DecodeError
        from mcap.exceptions import McapError

        try:
            yield from self._frames()
        except (McapError, DecodeError, struct.error, EOFError) as error:
            raise BadInput(f"{self.file}: not an MCAP log, or damaged or cut ({type(error).__name__})") from error

    def _frames(self) -> Iterator[Frame]:
        from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
        from mcap.reader import make_reader

        frozen = FrozenPicture()
        found = False
        with self.file.open("rb") as stream:
            for schema, _, message in make_reader(stream).iter_messages(topics=[self.topic]):
                if schema is None or schema.name != SCHEMA:
                    raise BadInput(f"{self.file}: {self.topic} holds {schema.name if schema else 'no'}, not {SCHEMA}")
                image = RawImage.FromString(message.data)
                if image.encoding != "mono16" or len(image.data) < image.step * image.height or image.step % 2:
                    raise BadInput(f"{self.file}: {self.topic}: a picture that is not mono16")
                rows = np.frombuffer(image.data, "<u2", image.step * image.height // 2).reshape(image.height, -1)
                counts = rows[:, : image.width].astype(np.uint16)
                at = image.timestamp.seconds + image.timestamp.nanos * 1e-9
                found = True
                yield Frame(counts, at, message.sequence, frozen.repeats(counts), kelvin_per_count=self._unit)
        if not found:
            raise BadInput(f"{self.file}: no pictures on {self.topic} in this log")
