"""A CPTV clip made from scratch, with whatever bit width is asked for."""

from __future__ import annotations

import gzip
import struct

import numpy as np
from numpy.typing import NDArray


def field(name: bytes, value: bytes) -> bytes:
    return bytes([len(value)]) + name + value


def section(kind: bytes, *fields: bytes) -> bytes:
    return kind + bytes([len(fields)]) + b"".join(fields)


def cptv_clip(
    frames: list[NDArray[np.uint16]],
    bits: int = 13,
    uptime_ms: int = 60_000,
    ffc_ms: int = 30_000,
    background: bool = False,
) -> bytes:
    """frames: (H, W) each, one every 111 ms. background: the first is a background picture."""
    height, width = frames[0].shape
    u32 = lambda value: struct.pack("<I", value)  # noqa: E731
    header = section(b"H", field(b"T", bytes(8)), field(b"X", u32(width)), field(b"Y", u32(height)),
                     field(b"C", b"\x01"), field(b"B", b"flir"), field(b"E", b"lepton3.5"))  # fmt: skip
    body = b""
    last = np.zeros(height * width, np.int64)
    for index, picture in enumerate(frames):
        path = picture.astype(np.int64).copy()
        path[1::2] = path[1::2, ::-1].copy()
        change = path.ravel() - last
        last = path.ravel()
        steps = np.diff(change)
        assert steps.min() >= -(1 << (bits - 1))
        assert steps.max() < 1 << (bits - 1)
        text = "".join(format(int(step) & ((1 << bits) - 1), f"0{bits}b") for step in steps)
        text = text.ljust(-len(text) % 8 + len(text), "0")
        packed = struct.pack("<i", change[0]) + int(text, 2).to_bytes(len(text) // 8, "big")
        body += (
            section(
                b"F",
                field(b"t", u32(uptime_ms + 111 * index)),
                field(b"c", u32(ffc_ms)),
                field(b"w", bytes([bits])),
                field(b"f", u32(len(packed))),
                field(b"g", b"\x01" if background and index == 0 else b"\x00"),
            )
            + packed
        )
    return gzip.compress(b"CPTV\x02" + header + body, mtime=0)
