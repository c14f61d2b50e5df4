"""Makes UF2 files for tests."""

from __future__ import annotations

import struct
from pathlib import Path

RP2040 = 0xE48BFF56
RP2350 = 0xE48BFF59
ABSOLUTE = 0xE48BFF57


def block(number: int, count: int, family: int = RP2040, flags: int = 0x2000, page: bytes | None = None) -> bytes:
    """One block of a page of flash."""
    header = struct.pack("<8I", 0x0A324655, 0x9E5D5157, flags, 0x1000_0000 + 256 * number, 256, number, count, family)
    return header + (page or bytes([number & 255]) * 256) + bytes(220) + struct.pack("<I", 0x0AB16F30)


def uf2_file(path: Path, count: int = 300, family: int = RP2040, before: bytes = b"") -> Path:
    """A whole file at `path`."""
    path.write_bytes(before + b"".join(block(number, count, family) for number in range(count)))
    return path


def marked_file(path: Path, board: int, git_hash: int) -> Path:
    """A file whose image says who it is, over the end of a page."""
    image = bytes(250) + b"rover image" + struct.pack("<BI", board, git_hash)
    image = image.ljust(512, b"\xff")
    path.write_bytes(b"".join(block(n, 2, page=image[256 * n : 256 * n + 256]) for n in range(2)))
    return path


def boot_drive(folder: Path, board: str = "RPI-RP2", model: str = "Raspberry Pi RP2") -> Path:
    """A folder that looks like the drive of a boot loader."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "INFO_UF2.TXT").write_text(f"UF2 Bootloader v3.0\r\nModel: {model}\r\nBoard-ID: {board}\r\n")
    return folder
