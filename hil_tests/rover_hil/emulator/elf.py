"""Reads what an ELF file puts into flash."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

from rover.errors import BadInput

HEADER = struct.Struct("<16sHHIIIIIHHHHHH")
PROGRAM_HEADER = struct.Struct("<IIIIIIII")
ARM, LOAD = 40, 1
FLASH = range(0x1000_0000, 0x1100_0000)


@dataclass(frozen=True)
class Segment:
    """Bytes that lie at `address` (a physical one) before the program starts."""

    address: int
    data: bytes


def flash_segments(path: Path) -> list[Segment]:
    """Loadable segments of a 32-bit ARM ELF, in flash. Raises BadInput."""
    try:
        image = path.read_bytes()
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror or error}; run 'make firmware'") from error
    try:
        header = HEADER.unpack_from(image)
        if header[0][:6] != b"\x7fELF\x01\x01" or header[2] != ARM:
            raise BadInput(f"{path}: not a 32-bit little-endian ELF for ARM; run 'make firmware'")
        first, size, count = header[5], header[9], header[10]
        segments = []
        for index in range(count):
            kind, offset, _, address, length, *_ = PROGRAM_HEADER.unpack_from(image, first + index * size)
            if kind != LOAD or not length:
                continue
            if address not in FLASH:
                raise BadInput(f"{path}: a segment lies at 0x{address:08x}, outside of flash")
            data = image[offset : offset + length]
            if len(data) < length:
                raise BadInput(f"{path}: ends inside a segment")
            segments.append(Segment(address, data))
    except struct.error as error:
        raise BadInput(f"{path}: ends inside a header") from error
    return segments
