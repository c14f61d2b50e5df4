"""TIFF files made byte by byte: what writers of thermal pictures do, and readers get wrong."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Order = Literal["<", ">"]
FORMATS = {"u": 1, "i": 2, "f": 3}


@dataclass
class Leaf:
    """One directory with its pixels (H, W) or (H, W, bands); sub: directories below it."""

    pixels: NDArray[np.generic]
    subfile_type: int | None = None
    compression: int = 1
    predictor: int = 1
    rows_per_strip: int | None = None
    sub: list[Leaf] = field(default_factory=list)


def tiff(*pages: Leaf, order: Order = "<") -> bytes:
    """The file; little-endian unless `order` is '>'."""
    out = bytearray(b"II*\0" if order == "<" else b"MM\0*") + bytes(4)
    link = 4
    for page in pages:
        at, end = _write(out, page, order)
        struct.pack_into(order + "I", out, link, at)
        link = end
    return bytes(out)


def _write(out: bytearray, page: Leaf, order: Order) -> tuple[int, int]:
    """Appends a directory; where it begins, and where its link to the next one stands."""
    below = [_write(out, leaf, order)[0] for leaf in page.sub]
    height, width = page.pixels.shape[:2]
    bands = page.pixels.shape[2] if page.pixels.ndim == 3 else 1
    kind = page.pixels.dtype
    step = page.rows_per_strip or height
    strips = []
    for row in range(0, height, step):
        packed = _packed(page.pixels[row : row + step], page, order)
        strips.append((len(out), len(packed)))
        out += packed + bytes(len(packed) % 2)
    entries: list[tuple[int, str, list[int]]] = []
    if page.subfile_type is not None:
        entries.append((254, "I", [page.subfile_type]))
    entries += [(256, "I", [width]), (257, "I", [height]), (258, "H", [8 * kind.itemsize] * bands),
                (259, "H", [page.compression]), (262, "H", [1]), (273, "I", [at for at, _ in strips]),
                (277, "H", [bands]), (278, "I", [step]), (279, "I", [size for _, size in strips]),
                (317, "H", [page.predictor])]  # fmt: skip
    if below:
        entries.append((330, "I", below))
    entries.append((339, "H", [FORMATS[kind.kind]] * bands))
    places = []
    for _, letter, values in entries:
        data = struct.pack(f"{order}{len(values)}{letter}", *values)
        if len(data) > 4:
            places.append(struct.pack(order + "I", len(out)))
            out += data
        else:
            places.append(data.ljust(4, b"\0"))
    begin = len(out)
    out += struct.pack(order + "H", len(entries))
    for (tag, letter, values), place in zip(entries, places, strict=True):
        out += struct.pack(order + "HHI", tag, {"H": 3, "I": 4}[letter], len(values)) + place
    out += bytes(4)
    return begin, len(out) - 4


def _packed(rows: NDArray[np.generic], page: Leaf, order: Order) -> bytes:
    kind = rows.dtype.newbyteorder(order)
    content = rows.astype(kind).tobytes()
    if page.predictor == 2:
        whole = rows.view(f"u{rows.dtype.itemsize}")
        content = np.diff(whole, axis=1, prepend=whole.dtype.type(0)).astype(f"{order}u{whole.itemsize}").tobytes()
    if page.predictor == 3:
        heavy_first = rows.astype(rows.dtype.newbyteorder(">")).view(np.uint8).reshape(*rows.shape, -1)
        planes = heavy_first.transpose(0, 2, 1).reshape(rows.shape[0], -1)
        content = np.diff(planes, axis=1, prepend=np.uint8(0)).tobytes()
    return zlib.compress(content) if page.compression in (8, 32946) else content
