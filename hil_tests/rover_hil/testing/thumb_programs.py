"""Small programs for the emulated processor, by hand: there is no assembler for it on a test machine."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from rover_plant import Clock, Processor

SRAM, STACK = 0x2000_0000, 0x2004_0000
# `b .`
FOREVER = 0xE7FE


def start(program: Sequence[int]) -> tuple[Clock, Processor, bytearray]:
    """A processor that begins with these half-words in SRAM."""
    rom = struct.pack("<II", STACK, SRAM | 1)
    flash, sram = bytearray(16 << 20), bytearray(264 << 10)
    words = [*program, FOREVER]
    sram[: 2 * len(words)] = struct.pack(f"<{len(words)}H", *words)
    clock = Clock()
    return clock, Processor(clock, rom, flash, sram, bytearray(4096)), sram


def run(program: Sequence[int], cycles: int = 10_000) -> list[int]:
    """Registers after the program."""
    _, processor, _ = start(program)
    processor.run_until(cycles)
    return processor.registers


def constant(register: int, value: int) -> list[int]:
    """Half-words that put `value` into a low register."""
    words = [0x2000 | register << 8 | value >> 24]
    for shift in (16, 8, 0):
        words += [0x0200 | register << 3 | register, 0x3000 | register << 8 | value >> shift & 0xFF]
    return words


def store(source: int, base: int, offset: int) -> int:
    """`str source, [base, #offset]`."""
    return 0x6000 | offset // 4 << 6 | base << 3 | source


def load(target: int, base: int, offset: int) -> int:
    """`ldr target, [base, #offset]`."""
    return 0x6800 | offset // 4 << 6 | base << 3 | target
