"""The marker segments before a JPEG's pixels, where cameras put what has no place in a JPEG (ITU-T T.81, B.1)."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rover.errors import BadInput

START_OF_IMAGE = b"\xff\xd8"
START_OF_SCAN, END_OF_IMAGE = 0xDA, 0xD9
APP1 = 0xE1
MARKER = re.compile(rb"\xff[^\x00\xff\xd0-\xd7]")


def check_end(data: bytes, name: str) -> None:
    """Raises BadInput for a JPEG without its last marker: it was cut, and what is left may not be all.

    What lies behind that marker is none of the picture's; cameras put further pictures there.
    """
    at = 2
    while True:
        # Between segments fill bytes; within a scan escaped bytes and restart markers, which are no ends.
        found = MARKER.search(data, at)
        if found is None:
            raise BadInput(f"{name}: cut JPEG: its end is missing")
        marker = data[found.end() - 1]
        if marker == END_OF_IMAGE:
            return
        at = found.end() + int.from_bytes(data[found.end() : found.end() + 2], "big")


def segments(data: bytes, name: str) -> Iterator[tuple[int, bytes]]:
    """Yields (marker, content) up to the first scan. Raises BadInput naming `name` where a segment is cut or broken."""
    if not data.startswith(START_OF_IMAGE):
        raise BadInput(f"{name}: not a JPEG")
    at = 2
    while at < len(data):
        if data[at] != 0xFF:
            raise BadInput(f"{name}: damaged JPEG: no marker at byte {at}")
        while at < len(data) and data[at] == 0xFF:  # a marker may be preceded by any number of fill bytes
            at += 1
        if at + 3 > len(data):
            break
        marker = data[at]
        if marker in (START_OF_SCAN, END_OF_IMAGE):
            return
        length = int.from_bytes(data[at + 1 : at + 3], "big")
        if length < 2 or at + 1 + length > len(data):
            raise BadInput(f"{name}: damaged or cut JPEG: the segment at byte {at - 1} is incomplete")
        yield marker, data[at + 3 : at + 1 + length]
        at += 1 + length
    raise BadInput(f"{name}: damaged or cut JPEG: it ends at byte {len(data)}, before any picture")
