"""How much of a file of another is taken in: what it declares is checked before memory is taken for it."""

from __future__ import annotations

import os
from pathlib import Path

from rover.errors import BadInput

# Of pictures and maps; commands hold up to 20 bytes a pixel. A drone's largest photographs have 48 million.
PIXELS = 50_000_000
PIXELS_VARIABLE = "ROVER_MAX_PIXELS"
# Files that are read whole, such as SEQ.
FILE_BYTES = 2**30
# Unpacked arrays of an archive that a run left.
ARCHIVE_BYTES = 512 * 2**20


def max_pixels() -> int:
    """PIXELS, or what the environment variable PIXELS_VARIABLE says. Raises BadInput where that is no number."""
    text = os.environ.get(PIXELS_VARIABLE, "")
    if not text:
        return PIXELS
    if not text.isdigit() or not int(text):
        raise BadInput(f"{PIXELS_VARIABLE}={text}: a number of pixels is expected")
    return int(text)


def check_pixels(width: int, height: int, name: str) -> None:
    """Raises BadInput naming `name` for a picture of more pixels."""
    limit = max_pixels()
    if width * height > limit:
        raise BadInput(
            f"{name}: {width}×{height} pixels, more than {limit / 1e6:g} million; "
            f"{PIXELS_VARIABLE} sets another limit, at some 20 bytes of memory a pixel"
        )


def read_bounded(path: Path) -> bytes:
    """The file's content. Raises BadInput for one of more than FILE_BYTES, or that cannot be read."""
    try:
        size = path.stat().st_size
        if size > FILE_BYTES:
            raise BadInput(f"{path}: {size / 2**20:.0f} MB, more than {FILE_BYTES // 2**20} MB: split it")
        return path.read_bytes()
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror or error}") from error
