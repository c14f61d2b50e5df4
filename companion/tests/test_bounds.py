"""What a file declares is checked before memory is taken for it: a small file cannot unpack to much."""

from __future__ import annotations

import io
import struct
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rover.archive_file import pack_archive, read_archive
from rover.capture.picture import read_picture
from rover.errors import BadInput

ALLOWED_MB = 300


def tiff(width: int, height: int, strips: list[bytes], compression: int, repeats: int = 1) -> bytes:
    """16 bits, one band; the strips stand one after the other, each named `repeats` times."""
    at, offsets, body = 8, [], b""
    for strip in strips:
        offsets.append(at + len(body))
        body += strip
    offsets, lengths = offsets * repeats, [len(strip) for strip in strips] * repeats
    tables = at + len(body)
    body += struct.pack(f"<{len(offsets)}I", *offsets) + struct.pack(f"<{len(lengths)}I", *lengths)
    directory = at + len(body)
    tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 16), (259, 3, 1, compression), (262, 3, 1, 1),
            (273, 4, len(offsets), tables if len(offsets) > 1 else offsets[0]), (277, 3, 1, 1),
            (278, 4, 1, height),
            (279, 4, len(lengths), tables + 4 * len(offsets) if len(lengths) > 1 else lengths[0])]  # fmt: skip
    entries = b"".join(struct.pack("<HHII", *tag) for tag in tags)
    return b"II*\0" + struct.pack("<I", directory) + body + struct.pack("<H", len(tags)) + entries + bytes(4)


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(100))), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*each) for each in chunks)


def bmp(width: int, height: int) -> bytes:
    return b"BM" + struct.pack("<IHHIIiiHHIIiiII", 54, 0, 0, 54, 40, width, height, 1, 24, 0, 0, 0, 0, 0, 0)


ZEROS = zlib.compress(bytes(400 * 2**20), 9)

HOSTILE: dict[str, Callable[[], bytes]] = {
    "a TIFF of 16384 × 16384": lambda: tiff(16384, 16384, [ZEROS], 8),
    "a PNG of 60000 × 60000": lambda: png(60000, 60000),
    "a PGM of 90000 × 90000": lambda: b"P5\n90000 90000\n65535\n" + bytes(1000),
    "a BMP of 40000 × 40000": lambda: bmp(40000, 40000),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_picture_that_declares_too_much_is_refused(name: str, tmp_path: Path) -> None:
    file = tmp_path / "hostile"
    file.write_bytes(HOSTILE[name]())
    with pytest.raises(BadInput, match=r"more (than|pixels)") as caught:
        read_picture(file)
    assert "\n" not in str(caught.value)


def test_strips_that_hold_more_than_the_picture_are_not_unpacked(tmp_path: Path) -> None:
    file = tmp_path / "bomb.tif"
    file.write_bytes(tiff(64, 64, [ZEROS], 8, repeats=1000))
    assert read_picture(file).shape == (64, 64)
    plain = tmp_path / "plain.tif"
    plain.write_bytes(tiff(64, 64, [bytes(400_000)], 1, repeats=60_000))
    assert read_picture(plain).shape == (64, 64)


@pytest.mark.parametrize("name", [*HOSTILE, "a TIFF whose strips hold 400 MB each"])
def test_no_more_memory_is_taken_than_allowed(name: str, tmp_path: Path) -> None:
    file = tmp_path / "hostile"
    file.write_bytes(HOSTILE[name]() if name in HOSTILE else tiff(64, 64, [ZEROS], 8, repeats=1000))
    code = (
        "import sys, contextlib; from rover.capture.picture import read_picture; from rover.errors import "
        "BadInput\nwith contextlib.suppress(BadInput): read_picture(sys.argv[1])\n"
        "print([line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')][0])"
    )
    # Of the process's own memory: what `getrusage` tells begins with that of the process that started it.
    done = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True, check=True)
    assert int(done.stdout) / 1024 < ALLOWED_MB


def test_the_limit_can_be_moved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "small.pgm"
    file.write_bytes(b"P5\n40 30\n255\n" + bytes(range(256)) * 5)
    monkeypatch.setenv("ROVER_MAX_PIXELS", "1000")
    with pytest.raises(BadInput, match="40×30 pixels"):
        read_picture(file)
    monkeypatch.setenv("ROVER_MAX_PIXELS", "1200")
    assert read_picture(file).shape == (30, 40)
    monkeypatch.setenv("ROVER_MAX_PIXELS", "many")
    with pytest.raises(BadInput, match="ROVER_MAX_PIXELS=many"):
        read_picture(file)


def test_an_archive_is_bounded_by_what_it_declares_and_by_what_it_holds(tmp_path: Path) -> None:
    whole = tmp_path / "whole.npz"
    whole.write_bytes(pack_archive({"a": np.arange(12.0).reshape(3, 4), "b": np.array([1, 2], np.uint8)}))
    found = read_archive(whole, "map")
    np.testing.assert_array_equal(found["a"], np.arange(12.0).reshape(3, 4))
    assert found["b"].dtype == np.uint8

    bomb = tmp_path / "bomb.npz"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as members:
        for number in range(2):
            members.writestr(f"a{number}.npy", bytes(300 * 2**20))
    assert bomb.stat().st_size < 2_000_000
    with pytest.raises(BadInput, match="600 MB unpacked"):
        read_archive(bomb, "map")

    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (2**40, 8)})
    liar = tmp_path / "liar.npz"
    with zipfile.ZipFile(liar, "w") as members:
        members.writestr("a.npy", header.getvalue() + bytes(64))
    with pytest.raises(BadInput, match="damaged"):
        read_archive(liar, "map")
