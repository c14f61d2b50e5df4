"""A page of a TIFF to pixels as they are meant: unsigned numbers, or floating point of 16, 32 and 64 bits.

What thermal cameras and photogrammetry write is unpacked here: 16 bits and floats, plain or deflated. OpenCV does the
rest; it insists on tags that cameras leave out, and takes half floats for whole numbers.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.bounds import check_pixels
from rover.capture.decoders import decode_quietly
from rover.capture.tiff_pages import Page
from rover.errors import BadInput

NONE, LZW, JPEG, DEFLATE, ADOBE_DEFLATE, PACK_BITS = 1, 5, 7, 32946, 8, 32773
COMPRESSIONS = {
    **{2: "CCITT", 3: "fax", 4: "fax", 6: "old JPEG", 34712: "JPEG 2000", 34887: "LERC", 34892: "lossy JPEG"},
    **{34925: "LZMA", 50000: "ZSTD", 50001: "WebP", 50002: "JPEG XL"},
}
FORMATS = {1: "unsigned", 2: "signed", 3: "floating-point"}
UNSIGNED, FLOAT = 1, 3
HORIZONTAL, FLOATING_POINT = 2, 3
MAX_SIDE_PX = 16_384


def decode_page(data: bytes, page: Page, name: str) -> NDArray[Any]:
    """(H, W) or, in colour, (H, W, 3): uint8, uint16, float32 or float64. Raises BadInput naming `name` and why not."""
    if page.samples not in (1, 3, 4):
        raise BadInput(f"{name}: a TIFF of {page.samples} bands of {page.bits} bits: one band is expected")
    if not (0 < page.width <= MAX_SIDE_PX and 0 < page.height <= MAX_SIDE_PX):
        raise BadInput(f"{name}: damaged TIFF: a page of {page.width}×{page.height} pixels")
    check_pixels(page.width, page.height, name)
    is_float = page.sample_format == FLOAT and page.bits in (16, 32, 64)
    if not is_float and not (page.sample_format == UNSIGNED and page.bits in (1, 4, 8, 16)):
        kind = FORMATS.get(page.sample_format, "unknown")
        raise BadInput(f"{name}: {page.bits}-bit {kind} pixels: 8 or 16 bits unsigned, or floating point, are expected")
    is_plain = page.samples == 1 and page.bits >= 16 and bool(page.strips)
    if is_plain and page.compression in (NONE, DEFLATE, ADOBE_DEFLATE):
        return _unpacked(data, page, name)
    # OpenCV reads the first page of a file: make this one the first.
    moved = data[:4] + struct.pack(page.order + "I", page.at) + data[8:]
    picture = None if is_float and page.bits != 32 else decode_quietly(moved)
    if picture is None:
        packing = COMPRESSIONS.get(page.compression)
        if packing is not None or is_float:
            what = f"{packing or 'this'} compression"
            raise BadInput(f"{name}: a TIFF with {what} is not supported: store it plain, or with deflate")
        raise BadInput(f"{name}: damaged or cut TIFF: its pixels cannot be unpacked")
    return picture


def _unpacked(data: bytes, page: Page, name: str) -> NDArray[Any]:
    kind = np.dtype(f"{page.order}{'f' if page.sample_format == FLOAT else 'u'}{page.bits // 8}")
    wanted = page.pixels * kind.itemsize
    parts: list[bytes] = []
    missing = wanted
    for at, count in page.strips:
        if missing <= 0:
            break  # what strips hold beyond the picture is not unpacked: it may be a thousand times as much
        try:
            part = data[at : at + count]
            parts.append(zlib.decompressobj().decompress(part, missing) if page.compression != NONE else part[:missing])
        except zlib.error as error:
            raise BadInput(f"{name}: damaged or cut TIFF: its pixels cannot be unpacked") from error
        missing -= len(parts[-1])
    content = b"".join(parts)
    if len(content) < wanted:
        raise BadInput(f"{name}: cut TIFF: {len(content)} of {wanted} bytes of pixels")
    content = content[:wanted]
    if page.predictor == FLOATING_POINT:
        rows = np.frombuffer(content, np.uint8).reshape(page.height, -1).cumsum(axis=1, dtype=np.uint8)
        # Bytes of one weight stand together, the heaviest first.
        planes = rows.reshape(page.height, kind.itemsize, page.width).transpose(0, 2, 1)
        pixels = np.ascontiguousarray(planes).view(kind.newbyteorder(">"))[..., 0]
    else:
        pixels = np.frombuffer(content, kind).reshape(page.height, page.width)
        if page.predictor == HORIZONTAL:
            whole = pixels.view(f"{page.order}u{kind.itemsize}")
            pixels = whole.cumsum(axis=1, dtype=f"u{kind.itemsize}").view(kind.newbyteorder("="))
    is_half = kind.kind == "f" and kind.itemsize == 2
    native: NDArray[Any] = pixels.astype(np.float32 if is_half else kind.newbyteorder("="))
    return native
