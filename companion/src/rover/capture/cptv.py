"""CPTV clips: losslessly packed thermal video of Lepton recorders (The Cacophony Project's format, versions 1 and 2).

A gzip stream of sections; a section is a letter and fields of (length, letter, value), little-endian. A frame is
the change from the one before it: the first pixel's change in 32 bits, then each pixel's difference to its
neighbour along a path that runs right and left in turns, packed most significant bit first.
"""

from __future__ import annotations

import gzip
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import FRAME_PERIOD, register
from rover.errors import BadInput

MAGIC = b"CPTV"
VERSIONS = (1, 2)
HEADER, FRAME = b"H", b"F"
WIDTH, HEIGHT, COMPRESSION, RATE, MODEL, BRAND = b"X", b"Y", b"C", b"Z", b"E", b"B"
BIT_WIDTH, FRAME_SIZE, TIME_ON, FFC_TIME, BACKGROUND = b"w", b"f", b"t", b"c", b"g"
MAX_SIDE_PX = 4096

Fields = dict[bytes, bytes]


@register("cptv")
class CptvSource:
    """`cptv:FILE[?unit=raw|centikelvin]`: counts are the sensor's own unless `unit` says otherwise.

    Times are the camera's, from the first frame on; the recorder's background picture is left out.
    Raises BadInput for a file that is missing, cut, damaged or of another version.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("unit",))
        self.file = Path(parsed.place)
        self._unit = parsed.unit("raw")
        if not self.file.is_file():
            raise BadInput(f"{self.file}: no such CPTV clip")

    def __iter__(self) -> Iterator[Frame]:
        try:
            with gzip.open(self.file, "rb") as stream:
                yield from self._frames(stream)  # type: ignore[arg-type]
        except (EOFError, OSError, zlib.error, struct.error, KeyError, ValueError) as error:
            if isinstance(error, BadInput):
                raise
            raise BadInput(f"{self.file}: not a CPTV clip, or damaged or cut ({error})") from error

    def _frames(self, stream: BinaryIO) -> Iterator[Frame]:
        version = _exactly(stream, 5)
        if version[:4] != MAGIC or version[4] not in VERSIONS:
            raise BadInput(f"{self.file}: not a CPTV clip of version 1 or 2")
        kind, header = _section(stream)
        width, height = _number(header[WIDTH]), _number(header[HEIGHT])
        if (
            kind != HEADER
            or _number(header[COMPRESSION]) != 1
            or not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX)
        ):
            raise ValueError("its header")
        period = 1.0 / _number(header[RATE]) if RATE in header and _number(header[RATE]) else FRAME_PERIOD
        camera = " ".join(header[key].decode("ascii", "replace") for key in (BRAND, MODEL) if key in header)
        path = _path(width, height)
        pixels = np.zeros(width * height, np.int64)
        frozen = FrozenPicture()
        began: int | None = None
        sequence = 0
        while True:
            kind, fields = _section(stream)
            if not kind:
                return
            if kind != FRAME:
                raise ValueError(f"a section {kind!r} among its frames")
            bits = _number(fields[BIT_WIDTH])
            pixels = pixels + _changes(_exactly(stream, _bounded(fields, width * height)), bits, width * height)
            if pixels.min() < 0 or pixels.max() > 65535:
                raise ValueError(f"pixels of frame {sequence} outside 16 bits")
            if BACKGROUND in fields and _number(fields[BACKGROUND]):
                continue
            counts = pixels[path].astype(np.uint16)
            uptime, ffc_at = (_number(fields[key]) if key in fields else None for key in (TIME_ON, FFC_TIME))
            began = uptime if began is None else began
            yield Frame(
                counts,
                sequence * period if uptime is None or began is None else (uptime - began) * 1e-3,
                sequence,
                frozen.repeats(counts),
                None if uptime is None or ffc_at is None else (uptime - ffc_at) * 1e-3,
                self._unit,
                camera,
            )
            sequence += 1


def _bounded(fields: Fields, pixels: int) -> int:
    size = _number(fields[FRAME_SIZE])
    if not 4 < size <= 8 + 2 * pixels:
        raise ValueError(f"a frame of {size} bytes")
    return size


def _changes(packed: bytes, bits: int, pixels: int) -> NDArray[np.int64]:
    """What is added to each pixel along the path, (pixels,)."""
    if not 1 <= bits <= 16:
        raise ValueError(f"differences of {bits} bits")
    (first,) = struct.unpack_from("<i", packed)
    stream = np.unpackbits(np.frombuffer(packed, np.uint8, offset=4))
    wanted = (pixels - 1) * bits
    if stream.size < wanted:
        raise ValueError("a frame is too short")
    places = stream[:wanted].reshape(-1, bits)
    weights = 1 << np.arange(bits - 1, -1, -1, dtype=np.int32)
    weights[0] = -weights[0]  # two's complement
    return np.cumsum(np.concatenate(([first], places @ weights)), dtype=np.int64)


def _path(width: int, height: int) -> NDArray[np.int64]:
    """Where each pixel (H, W) stands on the path: every second row runs from right to left."""
    path = np.arange(width * height).reshape(height, width)
    path[1::2] = path[1::2, ::-1].copy()
    return path


def _section(stream: BinaryIO) -> tuple[bytes, Fields]:
    kind = stream.read(1)
    if not kind:
        return b"", {}
    fields: Fields = {}
    for _ in range(_exactly(stream, 1)[0]):
        length, name = _exactly(stream, 1)[0], _exactly(stream, 1)
        fields[name] = _exactly(stream, length)
    return kind, fields


def _exactly(stream: BinaryIO, count: int) -> bytes:
    data = stream.read(count)
    if len(data) != count:
        raise EOFError("it ends too early")
    return data


def _number(value: bytes) -> int:
    return int.from_bytes(value, "little")
