"""The MCP2515 by its SPI bytes, on a bus with another node: DS20001801 and ISO 11898-1."""

from __future__ import annotations

import struct

import pytest
from rover_hil.emulator import mcp2515_registers as regs
from rover_hil.emulator.can_bus import CanBus, Frame
from rover_hil.emulator.mcp2515 import Mcp2515
from rover_hil.emulator.paced_adapter import OPENING_TICKS, PacedAdapter
from rover_hil.emulator.slcan import SlcanAdapter
from rover_hil.testing.thumb_programs import FOREVER, start


class Bench:
    """A controller and a serial adapter on one bus, and time."""

    def __init__(self, mode: int = regs.NORMAL, cnf: tuple[int, int, int] = (0x05, 0xB1, 0x00)) -> None:
        self.clock, self._processor, _ = start([FOREVER])
        self.bus = CanBus(self.clock)
        self.host = SlcanAdapter(self.bus)
        self.chip = Mcp2515(self.clock, self.bus)
        self.interrupts: list[bool] = []
        self.chip.on_interrupt = self.interrupts.append
        self.host.push(b"S6\rO\r")
        self.host.answers.clear()
        self.spi(0xC0)
        self.spi(0x02, regs.CNF3, *cnf)
        for control in regs.RX_CONTROL:
            self.spi(0x02, control, 0x64 if control == 0x60 else 0x60)
        self.spi(0x02, regs.CANINTE, 0xFF)
        self.spi(0x02, regs.CANCTRL, mode << 5)

    def spi(self, *data: int) -> bytes:
        self.chip.select(True)
        answer = bytes(self.chip.exchange(byte) for byte in data)
        self.chip.select(False)
        return answer

    def read(self, address: int) -> int:
        return self.spi(0x03, address, 0)[2]

    def send(self, identifier: int, data: bytes, buffer: int = 0) -> None:
        head = (identifier >> 3, identifier << 5 & 0xFF, 0, 0, len(data))
        self.spi(0x40 | 2 * buffer, *head, *data)
        self.spi(0x80 | 1 << buffer)

    def taken(self) -> int:
        """Frames that wait in the receive buffers; reading frees them."""
        waiting = self.spi(0xA0, 0)[1] & 3
        for buffer in range(2):
            if waiting >> buffer & 1:
                self.spi(0x90 | 4 * buffer, *[0] * 13)
        return waiting.bit_count()

    def wait_us(self, microseconds: float) -> None:
        self._processor.run_until(self.clock.cycles + round(microseconds * 125))


def test_a_frame_takes_its_bits_with_stuffing_and_reaches_the_other_node() -> None:
    # 0x2AA with alternating bytes has no run of five before the checksum: 47 + 8 bits a byte, and few stuff bits.
    assert 47 + 64 <= Frame(0x2AA, b"\xaa" * 8).bits() <= 47 + 64 + 3
    # Zeros: three stuff bits before the length, thirteen from there on.
    assert Frame(0, bytes(8)).bits() == 47 + 64 + 16
    bench = Bench()
    bench.send(0x123, b"\x01\x02")
    bits = Frame(0x123, b"\x01\x02").bits()
    bench.wait_us(2 * bits - 2)
    assert bench.host.answers == b""
    bench.wait_us(4)
    assert bench.host.answers == b"t12320102\r"
    assert bench.read(regs.CANINTF) & regs.TX0_FLAG
    assert bench.interrupts == [True]
    bench.spi(0x05, regs.CANINTF, regs.TX0_FLAG, 0)
    assert bench.interrupts == [True, False]


def test_a_frame_of_the_host_is_read_and_its_buffer_freed_by_the_end_of_the_reading() -> None:
    bench = Bench()
    bench.host.push(b"t2A53010203\r")
    bench.wait_us(300)
    assert bench.spi(0xA0, 0)[1] & 3 == 1
    head = bench.spi(0x90, *[0] * 8)[1:]
    assert head[0] << 3 | head[1] >> 5 == 0x2A5
    assert head[4:8] == b"\x03\x01\x02\x03"
    assert bench.spi(0xA0, 0)[1] & 3 == 0
    assert bench.interrupts == [True, False]


def test_a_second_frame_rolls_over_and_a_third_one_is_lost_with_its_flag() -> None:
    bench = Bench()
    for number in range(3):
        bench.host.push(b"t00%d0\r" % number)
    bench.wait_us(1000)
    assert bench.spi(0xA0, 0)[1] & 3 == 3
    assert [bench.spi(0x90 | 4 * n, 0, 0)[2] >> 5 for n in range(2)] == [0, 1]
    assert bench.read(regs.EFLG) & regs.RX1_OVERFLOW


def test_filters_take_what_their_mask_selects_and_say_which_one_it_was() -> None:
    bench = Bench(mode=regs.CONFIGURATION)
    bench.spi(0x02, regs.RX_CONTROL[0], 0)
    bench.spi(0x02, regs.RX_CONTROL[1], 0)
    for mask, value in zip(regs.MASKS, (0x780, 0x7FF), strict=True):
        bench.spi(0x02, mask, *struct.pack(">H", value << 5), 0, 0)
    for register, value in zip(regs.FILTERS, (0x000, 0x100, 0x7F0, 0x7F1, 0x7F2, 0x7F3), strict=True):
        bench.spi(0x02, register, *struct.pack(">H", value << 5), 0, 0)
    bench.spi(0x02, regs.CANCTRL, regs.NORMAL << 5)
    for identifier in (0x200, 0x17F, 0x7F2, 0x7F4):
        bench.host.push(b"t%03X0\r" % identifier)
    bench.host.push(b"T000001000\r")
    bench.wait_us(2000)
    assert bench.spi(0xA0, 0)[1] & 3 == 3
    assert bench.read(0x60) & 1 == 1, "0x17f by filter 1"
    assert bench.read(0x70) & 7 == 4, "0x7f2 by filter 4"


def test_the_lowest_identifier_wins_and_the_loser_tries_again() -> None:
    bench = Bench()
    bench.send(0x300, b"")
    bench.send(0x080, b"", buffer=1)
    bench.host.push(b"t1000\r")
    bench.wait_us(1000)
    # 0x300 was alone when it began; of the two others 0x080 goes first.
    assert bench.host.answers == b"t3000\rt0800\r"
    assert bench.spi(0x90, 0, 0)[1] << 3 == 0x100


def test_alone_on_the_bus_it_becomes_passive_and_never_off() -> None:
    bench = Bench()
    bench.host.push(b"C\r")
    bench.send(0x123, b"\x00" * 8)
    bench.wait_us(20_000)
    assert bench.read(regs.TEC) == 128
    assert bench.read(regs.EFLG) == regs.WARNING | regs.TX_WARNING | regs.TX_PASSIVE
    bench.host.push(b"O\r")
    bench.host.answers.clear()
    bench.wait_us(500)
    assert bench.host.answers.startswith(b"t1238")
    assert bench.read(regs.TEC) == 127


def test_bit_errors_switch_it_off_the_bus_and_it_comes_back_after_128_times_11_bits() -> None:
    bench = Bench()
    bench.bus.corrupt(32)
    bench.send(0x123, b"")
    bench.wait_us(32 * 2 * Frame(0x123).bits() + 10)
    assert bench.read(regs.EFLG) & regs.BUS_OFF
    bench.wait_us(128 * 11 * 2 - 200)
    assert bench.read(regs.EFLG) & regs.BUS_OFF
    bench.wait_us(600)
    assert not bench.read(regs.EFLG) & regs.BUS_OFF
    assert bench.host.answers == b"t1230\r"


def test_another_bit_rate_disturbs_everybody() -> None:
    bench = Bench(cnf=(0x05, 0xB1, 0x01))
    bench.host.push(b"t1000\r")
    bench.wait_us(5000)
    assert bench.read(regs.REC) > 0
    assert bench.spi(0xA0, 0)[1] & 3 == 0


def test_registers_that_need_configuration_mode_are_closed_elsewhere() -> None:
    bench = Bench()
    bench.spi(0x02, regs.CNF1, 0x3F)
    bench.spi(0x02, regs.MASKS[0], 0xFF)
    assert (bench.read(regs.CNF1), bench.read(regs.MASKS[0])) == (0, 0)
    assert bench.read(0x7E) == bench.read(regs.CANSTAT), "seen in every row"
    bench.spi(0xC0)
    assert bench.read(regs.CANSTAT) >> 5 == regs.CONFIGURATION


def test_loopback_sends_to_itself_and_nothing_to_the_bus() -> None:
    bench = Bench(mode=regs.LOOPBACK)
    bench.send(0x321, b"\x09")
    bench.wait_us(500)
    assert bench.spi(0xA0, 0)[1] & 1
    assert bench.host.answers == b""


@pytest.mark.parametrize("line", [b"t12", b"t12x0", b"t1239", b"t12320102030", b"T123", b"Q", b"S9", b"x" * 40])
def test_what_is_no_command_is_refused_by_the_adapter(line: bytes) -> None:
    bench = Bench()
    bench.host.push(line + b"\r")
    assert bench.host.answers == b"\x07"


class TestPacedAdapter:
    """The adapter of the lock-stepped board: frames go both ways in declared ticks."""

    def test_two_frames_of_the_host_go_on_the_bus_in_a_tick_and_none_while_the_adapter_opens(self) -> None:
        bench, adapter = _paced_bench()
        adapter.push(b"t0100\rt0200\rt0300\r")
        heard = []
        for _ in range(OPENING_TICKS + 2):
            adapter.release()
            bench.wait_us(1000)
            heard.append(bench.taken())
        assert heard == [0] * OPENING_TICKS + [2, 1]

    def test_what_a_tick_says_is_handed_over_once_it_is_through_the_lowest_identifier_first(self) -> None:
        bench, adapter = _paced_bench()
        bench.send(0x300, b"")
        bench.send(0x080, b"", buffer=1)
        bench.wait_us(1000)
        adapter.push(b"V\r")
        assert adapter.hand_over(bench.clock.cycles) == b"t0800\rt3000\rV0101\r"
        before = bench.clock.cycles
        bench.send(0x300, b"")
        bench.wait_us(1000)
        assert adapter.hand_over(before + 90 * 125) == b"", "it takes 94 us at least"
        assert adapter.hand_over(bench.clock.cycles) == b"t3000\r"


def _paced_bench() -> tuple[Bench, PacedAdapter]:
    """A bench whose host is a paced adapter that has just opened the bus."""
    bench = Bench()
    bench.host.push(b"C\r")
    adapter = PacedAdapter(bench.bus, bench.clock)
    adapter.push(b"S6\rO\r")
    adapter.answers.clear()
    return bench, adapter
