"""FLIR's file of records ("FFF"), alone or in APP1 segments of a JPEG: the raw picture and the camera's constants.

FLIR cameras write it big-endian, the cores in Zenmuse cameras little-endian, and each record has its own byte order;
all of it is found from fields whose value is known. The layout is public through ExifTool's description of the tags.
"""

from __future__ import annotations

import itertools
import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.bounds import check_pixels
from rover.capture.decoders import decode_quietly
from rover.capture.jpeg_segments import APP1
from rover.capture.radiometry import Radiometry
from rover.errors import BadInput

FILE_SIGNATURE = b"FFF\0"
SEGMENT_SIGNATURE = b"FLIR\0"
PNG_SIGNATURE = b"\x89PNG"
JPEG_LS_SIGNATURE = b"\xff\xd8\xff\xf7"
RECORD_RAW, RECORD_CAMERA = 1, 32
RECORD_BYTES, RAW_HEADER_BYTES = 32, 32
MAX_RECORDS, MAX_SIDE_PX = 1024, 8192
CAMERA_INFO_BYTES = 0x310
MODEL_AT, MODEL_BYTES = 0xD4, 32


@dataclass(frozen=True, eq=False)
class FlirFile:
    """raw: (H, W) uint16 counts of the sensor. radiometry: what turns them into temperatures. model: may be empty."""

    raw: NDArray[np.uint16]
    radiometry: Radiometry
    model: str


def join_segments(segments: Iterable[tuple[int, bytes]], name: str) -> bytes | None:
    """The FFF file that a JPEG carries in numbered parts; None without one. Raises BadInput when parts are missing."""
    parts: dict[int, bytes] = {}
    last = -1
    for marker, content in segments:
        if marker == APP1 and content.startswith(SEGMENT_SIGNATURE) and len(content) >= 8:
            parts[content[6]] = content[8:]
            last = max(last, content[7])
    if not parts:
        return None
    missing = [str(part) for part in range(last + 1) if part not in parts]
    if missing:
        raise BadInput(f"{name}: damaged: parts {', '.join(missing)} of {last + 1} of its thermal record are missing")
    return b"".join(parts[part] for part in sorted(parts))


def split_frames(data: bytes) -> list[bytes]:
    """The FFF files that follow each other in a SEQ; one where there is but one, whatever its state."""
    begins = [0]
    while True:
        # Records may hold the signature by chance: the next file begins behind all that this one announces.
        following = data.find(FILE_SIGNATURE, begins[-1] + max(_extent(data[begins[-1] :]), len(FILE_SIGNATURE)))
        if following < 0:
            return [data[begin:end] for begin, end in itertools.pairwise((*begins, len(data)))]
        begins.append(following)


def _extent(data: bytes) -> int:
    """Bytes from the start of an FFF file to the end of its last record; 0 where its index cannot be read."""
    try:
        order, at, count = _index(data)
        entries = (
            struct.unpack_from(order + "II", data, at + RECORD_BYTES * index + 12) for index in range(count)
        )
        return max((offset + length for offset, length in entries if offset + length <= len(data)), default=0)
    except struct.error:
        return 0


def _index(data: bytes) -> tuple[str, int, int]:
    """Byte order, and where the index of how many records lies."""
    (version,) = struct.unpack_from(">I", data, 0x14)
    order = ">" if 0 < version < 0x10000 else "<"
    at, count = struct.unpack_from(order + "II", data, 0x18)
    return order, at, min(count, MAX_RECORDS)


def parse(data: bytes, name: str) -> FlirFile:
    """Reads an FFF file. Raises BadInput naming `name` for anything that is cut, damaged or implausible."""
    try:
        records = _records(data)
        raw = _raw_picture(records[RECORD_RAW], name)
        radiometry, model = _camera(records[RECORD_CAMERA])
    except KeyError as error:
        what = {RECORD_RAW: "raw picture", RECORD_CAMERA: "camera constants"}.get(error.args[0], "file header")
        raise BadInput(f"{name}: no {what} in its thermal record: damaged, or not a radiometric file") from error
    except struct.error as error:
        raise BadInput(f"{name}: damaged thermal record: cut in the middle of a field") from error
    except ValueError as error:
        raise BadInput(f"{name}: damaged thermal record ({error})") from error
    radiometry.check(name)
    return FlirFile(raw, radiometry, model)


def _records(data: bytes) -> dict[int, tuple[int, bytes]]:
    if not data.startswith(FILE_SIGNATURE):
        raise KeyError("header")
    order, at, count = _index(data)
    found: dict[int, tuple[int, bytes]] = {}
    for index in range(count):
        kind, subtype, _, _, offset, length = struct.unpack_from(order + "HHIIII", data, at + RECORD_BYTES * index)
        if kind in (RECORD_RAW, RECORD_CAMERA) and kind not in found:
            if offset + length > len(data):
                raise ValueError(f"a record reaches to byte {offset + length} of {len(data)}")
            found[kind] = subtype, data[offset : offset + length]
    return found


def _byte_order(record: bytes) -> str:
    return "<" if struct.unpack_from("<H", record)[0] < 0x100 else ">"


def _raw_picture(record: tuple[int, bytes], name: str) -> NDArray[np.uint16]:
    """The kind of payload is told by its first bytes: the record's subtype is not kept to by all models."""
    _, content = record
    width, height = struct.unpack_from(_byte_order(content) + "HH", content, 2)
    payload = content[RAW_HEADER_BYTES:]
    if payload.startswith(PNG_SIGNATURE):
        check_png(payload)
        if struct.unpack_from(">II", payload, 16) != (width, height):
            raise ValueError(f"its PNG payload is not of the announced {width}×{height}")
        check_pixels(width, height, name)
        decoded = decode_quietly(payload)
        if decoded is None or decoded.dtype != np.uint16 or decoded.ndim != 2:
            raise ValueError("its PNG payload is not a readable 16-bit picture")
        if decoded.shape != (height, width):
            raise ValueError(f"its PNG payload is {decoded.shape[1]}×{decoded.shape[0]}, announced {width}×{height}")
        picture = np.asarray(decoded, np.uint16)
    elif payload.startswith(JPEG_LS_SIGNATURE):
        raise BadInput(f"{name}: pixels packed with JPEG-LS (CSQ) are not supported: export the file as SEQ or TIFF")
    else:
        if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
            raise ValueError(f"{width}×{height} pixels")
        if len(payload) < 2 * width * height:
            raise ValueError(f"{len(payload)} bytes of pixels, {2 * width * height} expected")
        picture = np.frombuffer(payload, np.dtype("<u2"), width * height).reshape(height, width)
    return smoother_byte_order(picture)


def check_png(payload: bytes) -> None:
    """Raises ValueError where a chunk's CRC does not fit (PNG 1.2, 3.4): the decoder would show what is left of it."""
    at = 8
    while payload[at + 4 : at + 8] != b"IEND":
        length, kind = struct.unpack_from(">I4s", payload, at)
        if at + 12 + length > len(payload):
            raise ValueError("its PNG payload is cut")
        (crc,) = struct.unpack_from(">I", payload, at + 8 + length)
        if crc != zlib.crc32(payload[at + 4 : at + 8 + length]):
            raise ValueError(f"the chunk {kind!r} of its PNG payload has a wrong CRC")
        at += 12 + length


def smoother_byte_order(picture: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """`picture` as it is or with its bytes swapped, whichever changes less from pixel to pixel.

    Nothing in the file says it reliably. In the wrong order the low byte counts 256-fold, so that neighbours jump.
    """
    swapped = picture.byteswap()
    return np.ascontiguousarray(min(picture, swapped, key=_roughness), dtype=np.uint16)


def _roughness(picture: NDArray[np.uint16]) -> float:
    wide = picture.astype(np.float32)
    return float(np.abs(np.diff(wide, axis=1)).sum() + np.abs(np.diff(wide, axis=0)).sum())


def _camera(record: tuple[int, bytes]) -> tuple[Radiometry, str]:
    _, content = record
    if len(content) < CAMERA_INFO_BYTES:
        raise ValueError(f"{len(content)} bytes of camera constants, {CAMERA_INFO_BYTES} expected")
    order = _byte_order(content)

    def real(at: int) -> float:
        return float(struct.unpack_from(order + "f", content, at)[0])

    humidity = real(0x3C)
    radiometry = Radiometry(
        emissivity=real(0x20),
        distance=real(0x24),
        reflected=real(0x28),
        air=real(0x2C),
        window=real(0x30),
        window_transmission=real(0x34),
        humidity=humidity / 100 if humidity > 2 else humidity,  # old models write percent
        planck_r1=real(0x58),
        planck_b=real(0x5C),
        planck_f=real(0x60),
        planck_o=float(struct.unpack_from(order + "i", content, 0x308)[0]),
        planck_r2=real(0x30C),
        alpha=(real(0x70), real(0x74)),
        beta=(real(0x78), real(0x7C)),
        mix=real(0x80),
    )
    model = content[MODEL_AT : MODEL_AT + MODEL_BYTES].split(b"\0")[0].decode("ascii", "replace").strip()
    return radiometry, model
