"""Which camera it was: make and model from a JPEG's EXIF (TIFF 6.0), for files whose thermal record does not say."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from rover.capture.jpeg_segments import APP1

SIGNATURE = b"Exif\0\0"
MAKE, MODEL = 0x010F, 0x0110
ASCII = 2


def camera_name(segments: Iterable[tuple[int, bytes]]) -> str:
    """Make and model in one string; empty when there is no readable EXIF."""
    for marker, content in segments:
        if marker == APP1 and content.startswith(SIGNATURE):
            try:
                tags = _ascii_tags(content[len(SIGNATURE) :])
            except (struct.error, KeyError):
                return ""
            make, model = tags.get(MAKE, ""), tags.get(MODEL, "")
            return model if model.lower().startswith(make.lower()) else f"{make} {model}".strip()
    return ""


def _ascii_tags(tiff: bytes) -> dict[int, str]:
    order = {b"II*\0": "<", b"MM\0*": ">"}[tiff[:4]]
    (directory,) = struct.unpack_from(order + "I", tiff, 4)
    (entries,) = struct.unpack_from(order + "H", tiff, directory)
    tags = {}
    for index in range(entries):
        tag, kind, count, value = struct.unpack_from(order + "HHII", tiff, directory + 2 + 12 * index)
        if tag in (MAKE, MODEL) and kind == ASCII:
            start = value if count > 4 else directory + 2 + 12 * index + 8
            tags[tag] = tiff[start : start + count].split(b"\0")[0].decode("ascii", "replace").strip()
    return tags
