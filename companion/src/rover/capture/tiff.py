"""Plain 16-bit TIFF as thermal cameras write it, where OpenCV's reader insists on tags that they leave out.

Baseline TIFF 6.0: first directory, one sample of 16 bits, no compression, strips. Everything else is left to OpenCV.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

WIDTH, LENGTH, BITS, COMPRESSION = 256, 257, 258, 259
STRIP_OFFSETS, SAMPLES, STRIP_BYTES = 273, 277, 279
FORMATS = {1: "B", 3: "H", 4: "I"}
MAX_SIDE = 16384


def decode_plain_tiff(data: bytes) -> NDArray[np.uint16] | None:
    """The picture (H, W) of an uncompressed 16-bit single-channel TIFF; None when `data` is anything else."""
    try:
        return _decode(data)
    except (struct.error, KeyError, IndexError, ValueError):
        return None


def _decode(data: bytes) -> NDArray[np.uint16] | None:
    order = {b"II*\0": "<", b"MM\0*": ">"}[data[:4]]
    (directory,) = struct.unpack_from(order + "I", data, 4)
    (entries,) = struct.unpack_from(order + "H", data, directory)
    tags: dict[int, tuple[int, ...]] = {}
    for index in range(entries):
        at = directory + 2 + 12 * index
        tag, kind, count = struct.unpack_from(order + "HHI", data, at)
        if kind not in FORMATS or count > MAX_SIDE:
            continue
        layout = f"{order}{count}{FORMATS[kind]}"
        where = at + 8
        if struct.calcsize(layout) > 4:
            (where,) = struct.unpack_from(order + "I", data, where)
        tags[tag] = struct.unpack_from(layout, data, where)
    width, height = tags[WIDTH][0], tags[LENGTH][0]
    if (
        tags[BITS] != (16,)
        or tags.get(COMPRESSION, (1,)) != (1,)
        or tags.get(SAMPLES, (1,)) != (1,)
        or not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE)
    ):
        return None
    strips = zip(tags[STRIP_OFFSETS], tags[STRIP_BYTES], strict=True)
    pixels = np.frombuffer(b"".join(data[a : a + n] for a, n in strips), dtype=order + "u2")
    return pixels[: width * height].reshape(height, width).astype(np.uint16)
