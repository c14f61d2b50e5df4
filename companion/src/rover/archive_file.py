"""Files of named arrays (npz) that a run leaves for a next one: the same arrays give the same bytes, damage is told."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

# What reading a damaged archive may raise, and taking its arrays for what they ought to be.
UNREADABLE = (OSError, ValueError, KeyError, TypeError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)


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
            if members.testzip() is not None:
                raise zipfile.BadZipFile("checksum")
        with np.load(path, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name]) for name in archive.files}
    except UNREADABLE as error:
        raise damaged(path, what) from error


def damaged(path: Path, what: str) -> BadInput:
    """The error for a file that is not what it ought to be."""
    return BadInput(f"{path}: damaged, or no {what}")
