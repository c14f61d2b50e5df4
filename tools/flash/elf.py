"""What a 32-bit little-endian ELF file puts into flash and RAM."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

ALLOCATED = 2
NO_CONTENTS = 8
LOAD = 1


@dataclass(frozen=True)
class Segment:
    """Bytes to be programmed at a physical address."""

    address: int
    data: bytes


@dataclass(frozen=True)
class Section:
    """A section that takes room in the target; `in_file` is false for memory that is only reserved."""

    name: str
    address: int
    size: int
    in_file: bool


def _header(data: bytes, path: Path) -> tuple[int, ...]:
    """Fields of the ELF header from e_type on (System V ABI, figure 4-3)."""
    if len(data) < 52 or data[:6] != b"\x7fELF\x01\x01":
        raise ValueError(f"{path}: not a 32-bit little-endian ELF file")
    return struct.unpack_from("<HHIIIIIHHHHHH", data, 16)


def segments(path: Path) -> list[Segment]:
    """What is to be programmed, in order of addresses. Raises ValueError when it is not such a file."""
    data = path.read_bytes()
    _, _, _, _, offset, _, _, _, size, count, _, _, _ = _header(data, path)
    found = []
    for number in range(count):
        kind, start, _, address, length, _, _, _ = struct.unpack_from("<8I", data, offset + number * size)
        if kind == LOAD and length:
            found.append(Segment(address, data[start : start + length]))
    return sorted(found, key=lambda segment: segment.address)


def sections(path: Path) -> list[Section]:
    """The sections that the target holds at run time, in file order."""
    data = path.read_bytes()
    _, _, _, _, _, offset, _, _, _, _, size, count, names = _header(data, path)
    headers = [struct.unpack_from("<10I", data, offset + number * size) for number in range(count)]
    strings = headers[names][4]
    found = []
    for name, kind, flags, address, _, length, *_ in headers:
        if flags & ALLOCATED and length:
            start = strings + name
            text = data[start : data.index(b"\0", start)].decode()
            found.append(Section(text, address, length, kind != NO_CONTENTS))
    return found
