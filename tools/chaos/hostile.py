"""Files that nobody would write, or only on purpose: what a command may be handed instead of what it wants."""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from pathlib import Path
from random import Random

import numpy as np

from tools.chaos.damage import DAMAGES


def png(width: int, height: int, bits: int = 16) -> bytes:
    """That declares so much and holds next to nothing."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(1000))), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)


def tiff(width: int, height: int, random: Random) -> bytes:
    """One strip of zeros, packed, and tags with values that do not fit."""
    packed = zlib.compress(bytes(50_000_000))
    tags = [
        (256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, random.choice((8, 16, 32))), (259, 3, 1, 8),
        (262, 3, 1, 1), (273, 4, 1, 8), (277, 3, 1, random.choice((1, 3, 65535))), (278, 4, 1, height),
        (279, 4, 1, len(packed)),
    ]  # fmt: skip
    entries = b"".join(struct.pack("<HHII", *tag) for tag in tags)
    return b"II*\0" + struct.pack("<I", 8 + len(packed)) + packed + struct.pack("<H", len(tags)) + entries + bytes(4)


def bomb(random: Random) -> bytes:
    """An archive of arrays that unpacks to a gigabyte."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as members:
        header = io.BytesIO()
        shape = random.choice(((2**40, 8), (30_000, 40_000), (0,), (-1, 4)))
        descriptor = {"descr": random.choice(("<f8", "|u1", "|O")), "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(header, descriptor)
        for name in ("content", "layer_seen", "looks", "version"):
            members.writestr(f"{name}.npy", header.getvalue() + bytes(250_000_000 if name == "looks" else 100))
    return file.getvalue()


def nested(random: Random) -> bytes:
    """Deep or long, in one of the formats that people write."""
    many = random.choice((500, 5_000, 200_000))
    return random.choice((
        b"[" * many,
        b"a = " + b"[" * many + b"]" * many,
        b".".join([b"a"] * many) + b" = 1",
        b"{" + b'"a":{' * many,
        b"- " * many,
        b"a: &a [x]\n" + b"".join(b"a%d: &a%d [*a, *a]\n" % (k, k) for k in range(20)),
        b"a: &a0 [lol]\n" + b"".join(b"b%d: &a%d [%s]\n" % (k, k, b"*a%d, " % (k - 1) * 9) for k in range(1, 30)),
        b"width = 3.0\nheight = 4.0\nobstacles = [" + b"[1.0, 1.0, 0.1]," * min(many, 60_000) + b"]",
        b"[mission]\nname = \"" + b"x" * many + b"\"",
        b"type octile\nheight 99999999\nwidth 99999999\nmap\n...",
        b"image: /dev/zero\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\nnegate: 0\n",
        b"P5\n99999 99999\n65535\n",
        b"[" + b"[0, 0], [1e308, 1e308], [nan, 1]," * 3 + b"[1, 1]]",
        b"[" + b",".join(b"[%d, %d]" % (k, k % 7) for k in range(min(many, 20_000))) + b"]",
    ))  # fmt: skip


def huge_picture(path: Path, random: Random) -> None:
    width, height = (random.choice((1, 3, 50, 7_000, 16_384, 60_000, 2**31 - 1)) for _ in range(2))
    many = (
        lambda: png(width, height, random.choice((1, 8, 16))),
        lambda: tiff(width, height, random),
        lambda: b"P5\n%d %d\n65535\n" % (width, height) + bytes(1000),
        lambda: b"BM" + struct.pack("<IHHIIiiHHIIiiII", 54, 0, 0, 54, 40, width, height, 1, 24, 0, 0, 0, 0, 0, 0),
        lambda: b"P6 %d %d 255 " % (width, height) + random.randbytes(500),
    )
    path.write_bytes(random.choice(many)())


def no_file(path: Path, random: Random) -> None:
    """What has a name and is no file."""
    kind = random.choice(("pipe", "zero", "folder", "dangling", "loop", "random"))
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        target = {"zero": "/dev/zero", "random": "/dev/urandom", "loop": str(path), "dangling": "/nowhere/at/all"}[kind]
        path.symlink_to(target)


def archive_bomb(path: Path, random: Random) -> None:
    path.write_bytes(bomb(random))


def nested_text(path: Path, random: Random) -> None:
    path.write_bytes(nested(random))


HOSTILE = (huge_picture, no_file, archive_bomb, nested_text, nested_text)
"""Made from nothing; most trials damage a file that is right, which gets further."""


def hostile_file(path: Path, right: bytes, random: Random) -> str:
    """Makes one at `path` from a file that would be right there, or from nothing; returns its kind."""
    if random.random() < 0.3:
        write = random.choice(HOSTILE)
        write(path, random)
        return write.__name__
    damage = random.choice(DAMAGES)
    path.write_bytes(damage(right, random))
    return damage.__name__
