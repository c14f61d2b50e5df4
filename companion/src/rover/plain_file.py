"""What is read as a file must be one: a pipe that nobody writes to, or an endless device, would be read for ever."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from rover.errors import BadInput

KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def plain_file(path: Path) -> Path:
    """The path, when a file is there or nothing is: what is missing, or a folder, is for its reader to say.

    Raises BadInput for a pipe, a device or a socket, under whatever name.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return path
    kind = next((name for is_kind, name in KINDS if is_kind(mode)), None)
    if kind is not None:
        raise BadInput(f"{path}: is {kind}, a file is wanted")
    return path
