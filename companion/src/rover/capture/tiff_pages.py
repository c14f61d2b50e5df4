"""The pages of a TIFF (6.0, and technical note 1 on SubIFDs): what each directory says of its pixels."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from rover.errors import BadInput

BYTE_ORDERS = {b"II*\0": "<", b"MM\0*": ">"}
SUBFILE_TYPE, WIDTH, HEIGHT, BITS, COMPRESSION = 254, 256, 257, 258, 259
STRIP_OFFSETS, SAMPLES, STRIP_BYTES, PREDICTOR = 273, 277, 279, 317
TILE_OFFSETS, SUB_DIRECTORIES, SAMPLE_FORMAT = 324, 330, 339
# struct's letter for each kind of number that is read here: byte, short, long, and the offset of a directory.
KINDS = {1: "B", 3: "H", 4: "I", 13: "I"}
# Bits of NewSubfileType: a smaller copy of another page, a mask.
NO_PICTURE = 0b101
MAX_PAGES, MAX_SIDE_PX = 100_000, 65_536


@dataclass(frozen=True)
class Page:
    """One directory. at: its offset in the file. bits: of one sample. sample_format: 1 unsigned, 2 signed, 3 float."""

    at: int
    order: str
    width: int
    height: int
    bits: int
    samples: int
    sample_format: int
    compression: int
    predictor: int
    subfile_type: int
    strips: tuple[tuple[int, int], ...]

    @property
    def pixels(self) -> int:
        """Number of pixels."""
        return self.width * self.height


def is_tiff(data: bytes) -> bool:
    """Whether the file begins as a TIFF with offsets of 32 bits."""
    return data[:4] in BYTE_ORDERS


def picture_pages(data: bytes, name: str) -> list[Page]:
    """The pages that are pictures, in order: all of the largest size, no smaller copies. Raises BadInput naming `name`.

    Writers put thumbnails first, last or below a page, with and without saying that they are such.
    """
    try:
        pages = _pages(data)
    except (struct.error, KeyError) as error:
        raise BadInput(f"{name}: damaged or cut TIFF: a directory of it cannot be read") from error
    whole = [page for page in pages if not page.subfile_type & NO_PICTURE] or pages
    if not whole:
        raise BadInput(f"{name}: a TIFF without a picture in it")
    largest = max(page.pixels for page in whole)
    return [page for page in whole if page.pixels == largest]


def _pages(data: bytes) -> list[Page]:
    order = BYTE_ORDERS[data[:4]]
    (first,) = struct.unpack_from(order + "I", data, 4)
    waiting, known, pages = [first], set[int](), []
    while waiting:
        at = waiting.pop(0)
        if at == 0 or at in known or len(known) >= MAX_PAGES:
            continue
        known.add(at)
        tags, following = _directory(data, at, order)
        waiting += [*tags.get(SUB_DIRECTORIES, ()), following]
        if WIDTH in tags and HEIGHT in tags:
            pages.append(_page(tags, at, order))
    return pages


def _directory(data: bytes, at: int, order: str) -> tuple[dict[int, tuple[int, ...]], int]:
    """Tags with whole numbers, and the offset of the next directory, 0 for none."""
    (entries,) = struct.unpack_from(order + "H", data, at)
    tags: dict[int, tuple[int, ...]] = {}
    for index in range(entries):
        entry = at + 2 + 12 * index
        tag, kind, count = struct.unpack_from(order + "HHI", data, entry)
        if kind not in KINDS or count > MAX_SIDE_PX:
            continue
        layout = f"{order}{count}{KINDS[kind]}"
        where = entry + 8
        if struct.calcsize(layout) > 4:
            (where,) = struct.unpack_from(order + "I", data, where)
        tags[tag] = struct.unpack_from(layout, data, where)
    (following,) = struct.unpack_from(order + "I", data, at + 2 + 12 * entries)
    return tags, following


def _page(tags: dict[int, tuple[int, ...]], at: int, order: str) -> Page:
    def one(tag: int, otherwise: int) -> int:
        return tags.get(tag, (otherwise,))[0]

    width, height = one(WIDTH, 0), one(HEIGHT, 0)
    offsets = tags.get(STRIP_OFFSETS, ())
    bits, samples = one(BITS, 1), one(SAMPLES, 1)
    # Some thermal cameras leave the lengths out: one strip, as long as the picture.
    lengths = tags.get(STRIP_BYTES, (width * height * samples * bits // 8,))
    strips = tuple(zip(offsets, lengths, strict=False)) if TILE_OFFSETS not in tags else ()
    return Page(
        at, order, width, height, bits, samples, one(SAMPLE_FORMAT, 1), one(COMPRESSION, 1), one(PREDICTOR, 1),
        one(SUBFILE_TYPE, 0), strips,
    )  # fmt: skip
