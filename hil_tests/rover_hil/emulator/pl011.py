"""The UART (ARM PL011, RP2040 datasheet 4.2): FIFOs, baud timing, interrupts on levels, line errors.

rp2040py sends at once, reads DMACR as all ones, asserts the transmit interrupt always and knows no receive timeout.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from rover_plant import Clock
from rp2040py._rp2040 import RP2040
from rp2040py.peripherals.peripheral import BasePeripheral

DR, RSR, FR, ILPR, IBRD, FBRD, LCR_H, CR = 0x00, 0x04, 0x18, 0x20, 0x24, 0x28, 0x2C, 0x30
IFLS, IMSC, RIS, MIS, ICR, DMACR = 0x34, 0x38, 0x3C, 0x40, 0x44, 0x48
PERIPHERAL_ID = {
    0xFE0: 0x11, 0xFE4: 0x10, 0xFE8: 0x34, 0xFEC: 0x00, 0xFF0: 0x0D, 0xFF4: 0xF0, 0xFF8: 0x05, 0xFFC: 0xB1,
}  # fmt: skip

RX_INTERRUPT, TX_INTERRUPT, RX_TIMEOUT = 1 << 4, 1 << 5, 1 << 6
FRAMING, PARITY, BREAK, OVERRUN = 1 << 8, 1 << 9, 1 << 10, 1 << 11
"""Error bits beside a byte in DR; in RIS the same ones stand one bit lower (4.2.8)."""
FR_BUSY, FR_RX_EMPTY, FR_TX_FULL, FR_RX_FULL, FR_TX_EMPTY = 1 << 3, 1 << 4, 1 << 5, 1 << 6, 1 << 7
UART_ENABLE, TX_ENABLE, RX_ENABLE = 1 << 0, 1 << 8, 1 << 9
FIFO_ENABLE = 1 << 4
FIFO_BYTES = 32
# Bytes in the FIFO at an eighth, a quarter, a half, three quarters and seven eighths.
TRIGGER_LEVELS = (4, 8, 16, 24, 28)
TIMEOUT_BITS = 32
# Where the stop bit of ten is sampled in a neighbouring bit.
BAUD_TOLERANCE = 0.04
PERIPHERAL_CLOCK_HZ = 125_000_000


class Pl011(BasePeripheral):
    """One UART. `on_sent(byte)` hears every byte when its stop bit has left; `receive` is the other direction."""

    def __init__(self, rp2040: RP2040, clock: Clock, name: str, irq: int) -> None:
        super().__init__(rp2040, name)
        self._irq = irq
        self._clock = clock
        self.on_sent: Callable[[int], None] = lambda _byte: None
        self._sent_alarm = self._clock.create_alarm(self._sent)
        self._timeout_alarm = self._clock.create_alarm(self._timed_out)
        self._rx: deque[int] = deque()
        self._tx: deque[int] = deque()
        self.reset()

    def reset(self) -> None:
        """Registers after a reset (4.2.8). What is on its way out is lost."""
        self._sent_alarm.cancel()
        self._timeout_alarm.cancel()
        self._rx.clear()
        self._tx.clear()
        self._shifting: int | None = None
        self._shift_end = 0.0
        self._overrun = 0
        self._errors = 0
        self._ibrd = self._fbrd = self._lcr = self._mask = self._raw = self._dma = 0
        self._cr = TX_ENABLE | RX_ENABLE
        self._levels = 0x12
        self.rp2040.set_interrupt(self._irq, False)

    @property
    def baud(self) -> float:
        """Bits per second that the divisors give (4.2.7.1); 0 before they are set."""
        divisor = self._ibrd + self._fbrd / 64
        return PERIPHERAL_CLOCK_HZ / (16 * divisor) if divisor else 0.0

    @property
    def bit_cycles(self) -> float:
        """Cycles of the system clock in one bit."""
        return 16 * (self._ibrd + self._fbrd / 64)

    @property
    def frame_bits(self) -> int:
        """Start, data, parity and stop bits of one character."""
        return 1 + 5 + (self._lcr >> 5 & 3) + (self._lcr >> 1 & 1) + 1 + (self._lcr >> 3 & 1)

    @property
    def unsent(self) -> int:
        """Bytes in the FIFO and in the shift register."""
        return len(self._tx) + (self._shifting is not None)

    def receive(self, byte: int, baud: float, errors: int = 0) -> None:
        """A character whose stop bit ends now, sent at `baud`; `errors` are bits of DR, as a noisy line makes them."""
        if not (self._cr & UART_ENABLE and self._cr & RX_ENABLE):
            return
        if not self.baud or abs(baud / self.baud - 1) > BAUD_TOLERANCE:
            errors |= FRAMING
        if errors:
            self._raise((errors >> 1) & 0x380)
        depth = FIFO_BYTES if self._lcr & FIFO_ENABLE else 1
        if len(self._rx) >= depth:
            # The character in the shift register is lost; the next one that is read says so.
            self._overrun = OVERRUN
            self._raise(OVERRUN >> 1)
            return
        self._rx.append(byte | errors)
        if len(self._rx) >= self._rx_level:
            self._raise(RX_INTERRUPT)
        self._timeout_alarm.schedule(TIMEOUT_BITS * self.bit_cycles * 8)

    @property
    def _rx_level(self) -> int:
        return TRIGGER_LEVELS[min(4, self._levels >> 3 & 7)] if self._lcr & FIFO_ENABLE else 1

    @property
    def _tx_level(self) -> int:
        return TRIGGER_LEVELS[min(4, self._levels & 7)] if self._lcr & FIFO_ENABLE else 0

    def _timed_out(self) -> None:
        if self._rx:
            self._raise(RX_TIMEOUT)

    def _raise(self, bits: int) -> None:
        self._raw |= bits
        self.rp2040.set_interrupt(self._irq, bool(self._raw & self._mask))

    def _lower(self, bits: int) -> None:
        self._raw &= ~bits
        self.rp2040.set_interrupt(self._irq, bool(self._raw & self._mask))

    def _read_data(self) -> int:
        if not self._rx:
            return 0
        value = self._rx.popleft() | self._overrun
        self._overrun = 0
        self._errors = value >> 8
        if len(self._rx) < self._rx_level:
            self._lower(RX_INTERRUPT)
        if not self._rx:
            self._timeout_alarm.cancel()
            self._lower(RX_TIMEOUT)
        return value

    def _write_data(self, byte: int) -> None:
        if not (self._cr & UART_ENABLE and self._cr & TX_ENABLE):
            return
        if self._shifting is None:
            self._shift_end = self._clock.cycles
            self._shift(byte)
        elif len(self._tx) < (FIFO_BYTES if self._lcr & FIFO_ENABLE else 1):
            self._tx.append(byte)
            if len(self._tx) > self._tx_level:
                self._lower(TX_INTERRUPT)

    def _shift(self, byte: int) -> None:
        self._shifting = byte
        # From the end of the last character, so that fractions of a cycle do not add up.
        self._shift_end += self.frame_bits * self.bit_cycles
        self._sent_alarm.schedule_at(round(self._shift_end))

    def _sent(self) -> None:
        byte, self._shifting = self._shifting, None
        if self._tx:
            before = len(self._tx)
            self._shift(self._tx.popleft())
            # On the transition through the level only, not while below it (4.2.6.3).
            if before - 1 <= self._tx_level < before:
                self._raise(TX_INTERRUPT)
        assert byte is not None
        self.on_sent(byte)

    def read_uint32(self, offset: int) -> int:
        """A register of table 4.2.8."""
        match offset:
            case 0x00:
                return self._read_data()
            case 0x18:
                return self._flags()
            case 0x3C:
                return self._raw
            case 0x40:
                return self._raw & self._mask
            case 0x38:
                return self._mask
            case 0x04:
                return self._errors
            case 0x24:
                return self._ibrd
            case 0x28:
                return self._fbrd
            case 0x2C:
                return self._lcr
            case 0x30:
                return self._cr
            case 0x34:
                return self._levels
            case 0x48:
                return self._dma
        return PERIPHERAL_ID.get(offset, 0)

    def write_uint32(self, offset: int, value: int) -> None:
        """A register of table 4.2.8."""
        if offset == DR:
            self._write_data(value & 0xFF)
        elif offset == ICR:
            self._lower(self.raw_write_value & 0x7FF)
        elif offset == IMSC:
            self._mask = value & 0x7FF
            self._raise(0)
        elif offset == RSR:
            self._errors = 0
        elif offset == IBRD:
            self._ibrd = value & 0xFFFF
        elif offset == FBRD:
            self._fbrd = value & 0x3F
        elif offset == LCR_H:
            self._lcr = value & 0xFF
        elif offset == CR:
            self._cr = value & 0xFF87
        elif offset == IFLS:
            self._levels = value & 0x3F
        elif offset == DMACR:
            self._dma = value & 7

    def _flags(self) -> int:
        depth = FIFO_BYTES if self._lcr & FIFO_ENABLE else 1
        return (
            (FR_BUSY if self._shifting is not None else 0)
            | (0 if self._rx else FR_RX_EMPTY)
            | (FR_RX_FULL if len(self._rx) >= depth else 0)
            | (0 if self._tx else FR_TX_EMPTY)
            | (FR_TX_FULL if len(self._tx) >= depth else 0)
        )
