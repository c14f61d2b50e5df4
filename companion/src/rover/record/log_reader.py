"""Reads a log back in the order in which it was written, whole or cut short by a dying process."""

from __future__ import annotations

import json
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from rover.errors import BadInput
from rover.link.intake import Cycle
from rover.plain_file import plain_file
from rover.record.device_cycle import unpack_cycle
from rover.record.epoch import epoch_of
from rover.record.rig_step import RigStep, unpack_step
from rover.record.topics import CAMERA_FRAME, CAMERA_THERMAL, RIG_CYCLE, RIG_STEP

KELVIN_IMAGE = "mono16"

# A length beyond this is damage: the largest record of a log is a model that was attached to it.
MAX_RECORD_BYTES = 512 * 2**20

# What mcap, the decompressor and the decoding of text raise where a file is cut or its bits are flipped. Their cyclic
# checksums cover what no decoder notices.
DAMAGED = (McapError, ZstdError, struct.error, ValueError, MemoryError, OverflowError)


@dataclass(frozen=True)
class LogMessage:
    """One message as it lies in the file; `time_ns` of the mission's clock."""

    topic: str
    time_ns: int
    data: bytes


@dataclass(frozen=True)
class LoggedFrame:
    """A picture: its header as a rig gives it (sequence, exposure_us, ffc, width, height), and its pixels."""

    time_ns: int
    header: dict[str, Any]
    pixels: bytes


class Log:
    """One MCAP file. `metadata` by name, `files` are its attachments, `epoch`: when its mission's clock began,
    `cut`: its end is missing.

    Raises BadInput when it is no MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.metadata: dict[str, dict[str, str]] = {}
        self.files: dict[str, bytes] = {}
        self.cut = False
        for record in self._records(chunks_whole=True):
            if isinstance(record, Metadata):
                self.metadata[record.name] = dict(record.metadata)
            elif isinstance(record, Attachment):
                self.files[record.name] = record.data
        self.epoch = epoch_of(self.metadata.get("clock"))

    def messages(self, topics: Collection[str] | None = None, without: Collection[str] = ()) -> Iterator[LogMessage]:
        """In the order of writing: those of `topics`, or all but those of `without`."""
        names: dict[int, str] = {}
        for record in self._records(chunks_whole=False):
            if isinstance(record, Channel):
                if record.topic not in without and (topics is None or record.topic in topics):
                    names[record.id] = record.topic
            elif isinstance(record, Message) and record.channel_id in names:
                at = record.log_time - self.epoch.utc_ns
                yield LogMessage(names[record.channel_id], at, record.data)

    def steps(self) -> Iterator[RigStep]:
        """What entered and left the firmware of a simulated rig."""
        for message in self.messages((RIG_STEP,)):
            try:
                yield unpack_step(message.data)
            except ValueError as error:
                raise BadInput(f"{self.path}: {RIG_STEP} at {message.time_ns * 1e-9:.3f} s: {error}") from error

    def cycles(self) -> Iterator[Cycle]:
        """What came over the wire of a real rover, cycle by cycle."""
        for message in self.messages((RIG_CYCLE,)):
            try:
                yield unpack_cycle(message.data)
            except ValueError as error:
                raise BadInput(f"{self.path}: {RIG_CYCLE} at {message.time_ns * 1e-9:.3f} s: {error}") from error

    def frames(self) -> Iterator[LoggedFrame]:
        """The camera's pictures, each with the time at which it was taken in."""
        header: dict[str, Any] = {}
        for message in self.messages((CAMERA_FRAME, CAMERA_THERMAL)):
            if message.topic == CAMERA_FRAME:
                header = json.loads(message.data)
                continue
            image = RawImage.FromString(message.data)
            if image.encoding != KELVIN_IMAGE or "sequence" not in header:
                raise BadInput(
                    f"{self.path}: {CAMERA_THERMAL} at {message.time_ns * 1e-9:.3f} s is not 16 bits, numbered"
                )
            size = {"width": image.width, "height": image.height}
            yield LoggedFrame(message.time_ns, {**header, **size}, image.data)

    def _records(self, chunks_whole: bool) -> Iterator[Any]:
        """All records up to where the file ends or is damaged."""
        begun = False
        try:
            with plain_file(self.path).open("rb") as stream:
                reader = StreamReader(
                    stream, emit_chunks=chunks_whole, validate_crcs=True, record_size_limit=MAX_RECORD_BYTES
                )
                for record in reader.records:
                    begun = True
                    yield record
        except DAMAGED as error:
            if stream_is_empty(self.path):
                raise BadInput(f"{self.path}: the file is empty") from None
            if not begun:
                why = (str(error).splitlines() or ["damaged"])[0]
                raise BadInput(f"{self.path}: not an MCAP log: {why}") from error
            self.cut = True
        except FileNotFoundError:
            raise BadInput(f"{self.path}: no such log") from None
        except OSError as error:
            raise BadInput(f"{self.path}: cannot be read: {error.strerror or error}") from error


def stream_is_empty(path: Path) -> bool:
    """True for a file of no bytes."""
    return path.stat().st_size == 0
