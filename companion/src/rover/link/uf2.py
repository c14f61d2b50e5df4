"""Reads UF2 files, the form in which a boot loader's drive takes a firmware: 512-byte blocks, each with a header.

The format is https://github.com/microsoft/uf2; the families are those of the boot ROMs (RP2040 datasheet 2.8.4.2,
RP2350 datasheet 5.5.3).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

from rover_protocol import messages

from rover.errors import BadInput
from rover.plain_file import plain_file

BLOCK_BYTES = 512
MAGIC = (0x0A324655, 0x9E5D5157)
MAGIC_END = 0x0AB16F30
NOT_FOR_FLASH = 0x0000_0001
FAMILY_PRESENT = 0x0000_2000
MAX_PAYLOAD_BYTES = 476

RP2040 = 0xE48BFF56
ABSOLUTE = 0xE48BFF57
DATA = 0xE48BFF58
RP2350_ARM = 0xE48BFF59
RP2350_RISCV = 0xE48BFF5A
RP2350_ARM_NON_SECURE = 0xE48BFF5B
FAMILY_NAMES = {
    RP2040: "RP2040",
    ABSOLUTE: "absolute",
    DATA: "data",
    RP2350_ARM: "RP2350",
    RP2350_RISCV: "RP2350 (RISC-V)",
    RP2350_ARM_NON_SECURE: "RP2350 (non-secure)",
}
FOR_ANY_BOARD = frozenset({ABSOLUTE, DATA})
# In an image of the rover's firmware, before the number of its board and the first 32 bits of its commit
# (firmware/pico/src/mark.rs).
MARK = b"rover image"


@dataclass(frozen=True)
class Mark:
    """Who the image in a file is: its board as HelloReply names it, and its commit, 8 hexadecimal digits."""

    board: str
    git_hash: str


@dataclass(frozen=True)
class Uf2:
    """A whole and consistent UF2 file."""

    path: Path
    content: bytes
    families: frozenset[int]

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.content) // BLOCK_BYTES

    @property
    def mark(self) -> Mark | None:
        """What the image says of itself; None when it is no firmware of this rover's, or an old one."""
        blocks = (self.content[at : at + BLOCK_BYTES] for at in range(0, len(self.content), BLOCK_BYTES))
        image = b"".join(block[32 : 32 + struct.unpack_from("<I", block, 16)[0]] for block in blocks)
        at = image.find(MARK) + len(MARK)
        if at < len(MARK) or len(image) < at + 5:
            return None
        board, git_hash = struct.unpack_from("<BI", image, at)
        return Mark(messages.VALUES["HelloReply"]["board"].get(board, f"Unknown{board}"), f"{git_hash:08x}")

    @property
    def family_names(self) -> str:
        """The boards that it is for, in words."""
        return ", ".join(FAMILY_NAMES.get(family, f"0x{family:08x}") for family in sorted(self.families))


def read_uf2(path: Path) -> Uf2:
    """The file, checked block by block. Raises BadInput that says which block is wrong."""
    try:
        content = plain_file(path).read_bytes()
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror or error}") from error
    if not content or len(content) % BLOCK_BYTES:
        raise BadInput(f"{path}: no UF2 file: {len(content)} bytes are not a whole number of {BLOCK_BYTES}-byte blocks")
    families: set[int] = set()
    expected: dict[int, int] = {}
    totals: dict[int, int] = {}
    for number in range(len(content) // BLOCK_BYTES):
        block = content[number * BLOCK_BYTES : (number + 1) * BLOCK_BYTES]
        family, index, count = _block(block, f"{path}: block {number}")
        # Blocks count within their family: a file for the RP2350 may begin with a single absolute one.
        if index != expected.get(family, 0):
            raise BadInput(f"{path}: block {number} says that it is number {index}: the file is not whole")
        expected[family], totals[family] = index + 1, count
        families.add(family)
    for family, count in totals.items():
        if expected[family] != count and family not in FOR_ANY_BOARD:
            raise BadInput(f"{path}: ends after {expected[family]} of {count} blocks: the file is not whole")
    if not families - FOR_ANY_BOARD:
        raise BadInput(f"{path}: does not say for which board it is")
    return Uf2(path, content, frozenset(families - FOR_ANY_BOARD))


def _block(block: bytes, where: str) -> tuple[int, int, int]:
    """Family, number and count of a block. Raises BadInput."""
    first, second, flags, _, size, number, count, family = struct.unpack_from("<8I", block)
    (end,) = struct.unpack_from("<I", block, BLOCK_BYTES - 4)
    if (first, second) != MAGIC or end != MAGIC_END:
        raise BadInput(f"{where} has not UF2's marks: this is no UF2 file, or it is damaged")
    if size > MAX_PAYLOAD_BYTES or flags & NOT_FOR_FLASH or not flags & FAMILY_PRESENT:
        raise BadInput(f"{where} is not meant for the flash of a named board (flags 0x{flags:08x}, {size} bytes)")
    return family, number, count
