"""The emulated processor: the same results as rp2040py's own, and the datasheet's where that one differs."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from rover_hil.testing.thumb_programs import FOREVER, SRAM, STACK, constant, load, run, start, store

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rp2040py.rp2040 import RP2040

# `mrs r7, apsr`
READ_STATUS = (0xF3EF, 0x8700)
# With a register as amount; rp2040py changes the carry when it is 0, or above 32.
REGISTER_SHIFTS = (0x4080, 0x40C0, 0x4100, 0x41C0)


def random_program(generator: np.random.Generator) -> list[int]:
    """Arithmetic on low registers: immediates, three-register forms and the data-processing group."""
    words: list[int] = []
    for register in range(7):
        words += constant(register, int(generator.integers(1 << 32)))
    while len(words) < 200:
        word = int(generator.integers(0x4400))
        registers = {word & 7, word >> 8 & 7} if 0x2000 <= word < 0x4000 else {word & 7}
        if 7 in registers or word & 0xFFC0 in REGISTER_SHIFTS:
            continue
        words.append(word)
    return [*words, *READ_STATUS]


@pytest.mark.parametrize("seed", range(20))
def test_arithmetic_gives_the_same_registers_and_flags_as_rp2040py(seed: int) -> None:
    program = random_program(np.random.default_rng(seed))
    reference = RP2040()
    reference.sram[: 2 * len(program) + 2] = struct.pack(f"<{len(program) + 1}H", *program, FOREVER)
    reference.core.pc, reference.core.sp = SRAM, STACK
    for _ in range(len(program) + 5):
        reference.core.execute_instruction()
    assert run(program)[:8] == list(reference.core.registers)[:8]


def test_a_shift_by_a_register_of_zero_keeps_the_carry() -> None:
    # cmp r0, r0 sets the carry; lsls, lsrs and asrs by r1 = 0 leave it.
    for shift in (0x4088, 0x40C8, 0x4108):
        assert run([0x2000, 0x2100, 0x4280, shift, *READ_STATUS])[7] >> 29 & 1 == 1


@pytest.mark.parametrize(
    ("dividend", "divisor", "signed", "quotient", "remainder"),
    [
        (100, 7, False, 14, 2),
        (-100, 7, True, -14, -2),
        (7, 0, False, -1, 7),
        (-7, 0, True, 1, -7),
        (-(2**31), -1, True, -(2**31), 0),
    ],
)
def test_the_divider_follows_the_datasheet(
    dividend: int, divisor: int, signed: bool, quotient: int, remainder: int
) -> None:
    first = 0x68 if signed else 0x60
    program = [
        *constant(0, 0xD000_0000),
        *constant(1, dividend & 0xFFFF_FFFF),
        *constant(2, divisor & 0xFFFF_FFFF),
        store(1, 0, first),
        store(2, 0, first + 4),
        load(4, 0, 0x74),
        load(3, 0, 0x70),
    ]
    registers = run(program)
    assert registers[3:5] == [quotient & 0xFFFF_FFFF, remainder & 0xFFFF_FFFF]


def test_a_timer_alarm_comes_in_its_microsecond_and_not_before() -> None:
    program = [
        *constant(0, 0x4005_4000),
        *constant(2, 50),
        store(2, 0, 0x10),
        load(3, 0, 0x34),  # wait for INTR
        0x2B00,  # cmp r3, #0
        0xD0FC,  # beq back to the load
        load(4, 0, 0x28),
    ]
    assert run(program, 20_000)[4] == 50


def test_an_interrupt_enters_its_handler_and_returns_to_where_it_came_from() -> None:
    handler = SRAM + 0x200
    program = [
        *constant(0, 0xE000_E100),
        *constant(1, 1 << 5),
        store(1, 0, 0),  # NVIC_ISER
        *constant(2, SRAM + 0x100),
        *constant(0, 0xE000_ED00),
        store(2, 0, 8),  # VTOR
        0xBF30,  # wfi
        0x2355,  # movs r3, #0x55
    ]
    _, processor, sram = start(program)
    struct.pack_into("<I", sram, 0x100 + 4 * (16 + 5), handler | 1)
    struct.pack_into("<2H", sram, 0x200, 0x24AA, 0x4770)  # movs r4, #0xaa; bx lr
    processor.run_until(1000)
    assert processor.registers[3:5] == [0, 0], "asleep until the line rises"
    processor.set_interrupt(5, True)
    processor.set_interrupt(5, False)
    processor.run_until(2000)
    assert processor.exception == 0
    assert processor.registers[3:5] == [0x55, 0xAA]


def test_a_fault_in_a_fault_handler_locks_the_processor_up() -> None:
    # The vector table is the ROM of `start`, where no handler is: the first fault runs into the next.
    with pytest.raises(RuntimeError, match="locked up"):
        run([0xDE00])
