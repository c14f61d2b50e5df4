"""Files that are there complete or not at all, whatever dies while they are written."""

from __future__ import annotations

import os
from pathlib import Path


def write_whole(path: Path, data: bytes) -> None:
    """Puts `data` on disk in place of what lay there. Raises OSError; the old file is then untouched."""
    # Beside the file itself: a rename is atomic only within a file system.
    part = path.with_name(f".{path.name}.part")
    try:
        with part.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
