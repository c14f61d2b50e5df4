"""A radiometric JPEG made from scratch, in every layout that cameras use."""

from __future__ import annotations

import struct

import cv2
import numpy as np
from numpy.typing import NDArray

PLANCK = {"r1": 16951.8, "b": 1435.1, "f": 1.0, "o": -7142, "r2": 0.014294867}
MODEL = "Sample 80"


def counts_of(kelvin: NDArray[np.float64]) -> NDArray[np.uint16]:
    """Planck's law with the sample's constants: what an ideal black body at arm's length gives."""
    p = PLANCK
    return np.rint(p["r1"] / (p["r2"] * (np.exp(p["b"] / kelvin) - p["f"])) - p["o"]).astype(np.uint16)


def flir_file(raw: NDArray[np.uint16], payload: str, order: str, record_order: str = "<", **changed: float) -> bytes:
    """An FFF file. payload: "raw", "raw-swapped", "png" or "png-swapped"; order: of the directory, "<" or ">"."""
    height, width = raw.shape
    stored = raw.byteswap() if payload.endswith("swapped") else raw
    png = cv2.imencode(".png", stored)[1].tobytes()
    pixels = png if payload.startswith("png") else stored.astype("<u2").tobytes()
    picture = struct.pack(record_order + "HHH", 2, width, height).ljust(32, b"\0") + pixels
    values = {
        0x20: 1.0, 0x24: 0.0, 0x28: 293.15, 0x2C: 293.15, 0x30: 293.15, 0x34: 1.0, 0x3C: 0.5,
        0x58: PLANCK["r1"], 0x5C: PLANCK["b"], 0x60: PLANCK["f"], 0x70: 0.006569, 0x74: 0.01262, 0x78: -0.002276,
        0x7C: -0.00667, 0x80: 1.9, 0x30C: PLANCK["r2"],
    }  # fmt: skip
    values.update({int(key[2:], 16): value for key, value in changed.items()})
    camera = bytearray(0x400)
    struct.pack_into(record_order + "H", camera, 0, 2)
    for at, value in values.items():
        struct.pack_into(record_order + "f", camera, at, value)
    struct.pack_into(record_order + "i", camera, 0x308, int(PLANCK["o"]))
    camera[0xD4 : 0xD4 + len(MODEL)] = MODEL.encode()
    head = b"FFF\0" + b"SAMPLE".ljust(16, b"\0") + struct.pack(order + "III", 100, 64, 2)
    first, second = 128, 128 + len(picture)
    directory = b"".join(
        struct.pack(order + "HHIIII", kind, 1, 100, 1, at, length).ljust(32, b"\0")
        for kind, at, length in ((1, first, len(picture)), (32, second, len(camera)))
    )
    return head.ljust(64, b"\0") + directory + picture + bytes(camera)


def jpeg_with(record: bytes, part_bytes: int = 4000) -> bytes:
    """The record in numbered APP1 segments of an otherwise ordinary JPEG."""
    parts = [record[at : at + part_bytes] for at in range(0, len(record), part_bytes)]
    segments = b"".join(
        b"\xff\xe1" + struct.pack(">H", len(part) + 10) + b"FLIR\0\1" + bytes((index, len(parts) - 1)) + part
        for index, part in enumerate(parts)
    )
    plain = cv2.imencode(".jpg", np.zeros((8, 8), np.uint8))[1].tobytes()
    return plain[:2] + segments + plain[2:]
