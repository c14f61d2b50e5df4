"""The UF2 file holds what the ELF file puts into flash, page by page, and the size report counts it."""

from __future__ import annotations

import struct
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def elf_file(segments: list[tuple[int, bytes]], bss: int = 0) -> bytes:
    """An ELF file with these loadable segments, a section for each, and reserved RAM."""
    names = b"\0.text\0.bss\0.names\0"
    headers = 52 + 32 * len(segments)
    data = b"".join(content for _, content in segments) + names
    program, sections, offset = b"", [bytes(40)], headers
    for address, content in segments:
        program += struct.pack("<8I", 1, offset, address, address, len(content), len(content), 5, 4)
        sections.append(struct.pack("<10I", 1, 1, 2, address, offset, len(content), 0, 0, 4, 0))
        offset += len(content)
    sections.append(struct.pack("<10I", 7, 8, 3, 0x2000_0000, 0, bss, 0, 0, 4, 0))
    sections.append(struct.pack("<10I", 12, 3, 0, 0, offset, len(names), 0, 0, 1, 0))
    fields = (
        2,
        40,
        1,
        0x1000_0101,
        52,
        offset + len(names),
        0,
        52,
        32,
        len(segments),
        40,
        len(sections),
        len(sections) - 1,
    )
    return (
        b"\x7fELF\x01\x01\x01" + bytes(9) + struct.pack("<HHIIIIIHHHHHH", *fields) + program + data + b"".join(sections)
    )


def convert(tmp_path: Path, content: bytes, *options: str) -> tuple[subprocess.CompletedProcess[str], Path]:
    source, target = tmp_path / "firmware.elf", tmp_path / "firmware.uf2"
    source.write_bytes(content)
    command: list[str | Path] = [sys.executable, "-m", "tools.flash.uf2", *options, source, target]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True), target


def test_each_page_becomes_a_block_with_what_is_not_covered_erased(tmp_path: Path) -> None:
    boot, code = bytes(range(256)), b"\x01\x02\x03\x04" * 75
    result, target = convert(tmp_path, elf_file([(0x1000_0000, boot), (0x1000_0110, code)], bss=1000))
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "flash 556 bytes, static RAM 1000 bytes"
    blocks = [target.read_bytes()[i : i + 512] for i in range(0, target.stat().st_size, 512)]
    assert len(blocks) == 3
    for number, block in enumerate(blocks):
        words = struct.unpack_from("<8I", block)
        assert words == (0x0A324655, 0x9E5D5157, 0x2000, 0x1000_0000 + 256 * number, 256, number, 3, 0xE48BFF56)
        assert block[-4:] == bytes.fromhex("306fb10a")
    flash = b"".join(block[32:288] for block in blocks)
    assert flash == boot + b"\xff" * 16 + code + b"\xff" * (256 * 3 - 256 - 16 - 300)


def test_each_chip_has_its_family(tmp_path: Path) -> None:
    """The boot loader of one chip refuses the other's file."""
    image = elf_file([(0x1000_0000, bytes(256))])
    for chip, family in (("rp2040", 0xE48BFF56), ("rp2350", 0xE48BFF59)):
        result, target = convert(tmp_path, image, "--chip", chip)
        assert result.returncode == 0, result.stderr
        assert struct.unpack_from("<I", target.read_bytes(), 28) == (family,)


def test_a_segment_outside_of_flash_is_refused(tmp_path: Path) -> None:
    result, target = convert(tmp_path, elf_file([(0x2000_0000, b"1234")]))
    assert result.returncode == 2
    assert result.stderr == "segment at 0x20000000 lies outside of flash\n"
    assert not target.exists()


def test_another_file_is_refused(tmp_path: Path) -> None:
    result, _ = convert(tmp_path, b"MZ" + bytes(100))
    assert result.returncode == 2
    assert result.stderr.endswith("firmware.elf: not a 32-bit little-endian ELF file\n")
