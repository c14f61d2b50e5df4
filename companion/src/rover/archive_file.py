"""Files of named arrays (npz) that a run leaves for a next one: the same arrays give the same bytes, damage is told."""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.bounds import ARCHIVE_BYTES
from rover.errors import BadInput

# What reading a damaged archive may raise, and taking its arrays for what they ought to be.
UNREADABLE = (OSError, ValueError, KeyError, TypeError, EOFError, RuntimeError, MemoryError, NotImplementedError,
              zipfile.BadZipFile, zlib.error)  # fmt: skip


def pack_archive(arrays: dict[str, NDArray[Any]]) -> bytes:
    """The archive as it lies on disk, uncompressed."""
    packed = io.BytesIO()
    np.savez(packed, **arrays)  # type: ignore[arg-type]
    return packed.getvalue()


def write_archive(path: Path, what: str, arrays: dict[str, NDArray[Any]]) -> None:
    """Writes an archive. Raises BadInput where the file cannot be written; `what` it is, for people."""
    try:
        path.write_bytes(pack_archive(arrays))
    except OSError as error:
        raise BadInput(f"{path}: the {what} cannot be written: {error.strerror or error}") from error


def read_archive(path: Path, what: str) -> dict[str, NDArray[Any]]:
    """All arrays, their checksums tried. Raises BadInput, one line, for a file that is missing or damaged."""
    if not path.is_file():
        raise BadInput(f"{path}: no such {what}; a run's folder or its {path.name} is expected")
    try:
        with zipfile.ZipFile(path) as members:
            entries = members.infolist()
            declared = sum(entry.file_size for entry in entries)
            if declared > ARCHIVE_BYTES:
                raise BadInput(f"{path}: {declared / 2**20:.0f} MB unpacked, more than {ARCHIVE_BYTES // 2**20} MB")
            return {entry.filename.removesuffix(".npy"): _array(members, entry) for entry in entries}
    except BadInput:
        raise
    except UNREADABLE as error:
        raise damaged(path, what) from error


def _array(members: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    """One array, its checksum tried. Raises ValueError where its header announces more than there is."""
    content = members.read(entry)
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    shape, _, kind = readers[version](stream)
    if math.prod(shape) * kind.itemsize > len(content):
        raise ValueError(f"{shape} of {kind} in {len(content)} bytes")
    stream.seek(0)
    return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))


def damaged(path: Path, what: str) -> BadInput:
    """The error for a file that is not what it ought to be."""
    return BadInput(f"{path}: damaged, or no {what}")
