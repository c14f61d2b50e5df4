"""Turn an ELF file for the RP2040 or RP2350 into the UF2 file that its boot loader takes, and report sizes.

    python -m tools.flash.uf2 rover-pico.elf rover-pico.uf2
    python -m tools.flash.uf2 --chip rp2350 rover-pico2.elf rover-pico2.uf2

A UF2 file is a row of 512-byte blocks, each with a header, 256 bytes for one page of flash, and a closing word.
"""

from __future__ import annotations

import argparse
import struct
import sys
from pathlib import Path

from tools.flash import elf

MAGIC = (0x0A324655, 0x9E5D5157)
MAGIC_END = 0x0AB16F30
FAMILY_PRESENT = 0x2000
# By chip; of the RP2350 with its ARM cores in secure mode (datasheet section 5.5.3).
FAMILIES = {"rp2040": 0xE48BFF56, "rp2350": 0xE48BFF59}

PAGE = 256
FLASH = range(0x1000_0000, 0x1100_0000)
# Of the RP2350, which has more of it.
RAM = range(0x2000_0000, 0x2008_2000)


def pages(segments: list[elf.Segment]) -> dict[int, bytes]:
    """Flash pages by address; what no segment covers of a page is 0xFF, as after erasing.

    Raises ValueError when a segment lies outside of flash.
    """
    found: dict[int, bytearray] = {}
    for segment in segments:
        end = segment.address + len(segment.data)
        if segment.address not in FLASH or end > FLASH.stop:
            raise ValueError(f"segment at 0x{segment.address:08x} lies outside of flash")
        for offset, byte in enumerate(segment.data):
            address = segment.address + offset
            page = found.setdefault(address - address % PAGE, bytearray(b"\xff" * PAGE))
            page[address % PAGE] = byte
    return {address: bytes(found[address]) for address in sorted(found)}


def uf2(content: dict[int, bytes], family: int) -> bytes:
    """The UF2 file with these pages, for one of FAMILIES."""
    blocks = []
    for number, (address, page) in enumerate(content.items()):
        header = struct.pack("<8I", *MAGIC, FAMILY_PRESENT, address, PAGE, number, len(content), family)
        blocks.append(header + page.ljust(476, b"\0") + struct.pack("<I", MAGIC_END))
    return b"".join(blocks)


def sizes(path: Path) -> dict[str, int]:
    """Bytes of flash (code, constants and what RAM starts with) and of RAM that is given away statically."""
    found = elf.sections(path)
    return {
        "flash": sum(len(segment.data) for segment in elf.segments(path)),
        "ram": sum(section.size for section in found if section.address in RAM),
    }


def report(path: Path) -> str:
    lines = [f"{'section':<14}{'address':>12}{'bytes':>10}"]
    for section in elf.sections(path):
        lines.append(f"{section.name:<14}{section.address:#12x}{section.size:>10}")
    total = sizes(path)
    lines.append(f"flash {total['flash']} bytes, static RAM {total['ram']} bytes")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--chip", choices=FAMILIES, default="rp2040", help="default: %(default)s")
    parser.add_argument("elf", type=Path)
    parser.add_argument("uf2", type=Path)
    options = parser.parse_args()
    try:
        options.uf2.write_bytes(uf2(pages(elf.segments(options.elf)), FAMILIES[options.chip]))
        print(report(options.elf))
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
