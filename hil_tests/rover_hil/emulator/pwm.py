"""PWM slices as registers (RP2040 datasheet 4.5): mean levels of the outputs instead of edges.

rp2040py makes three callbacks out of each period of each slice, 120,000 a second for two motors at 20 kHz. The
plant's motors see nothing of a period but its mean, which the registers give.
"""

from __future__ import annotations

from rp2040py._rp2040 import RP2040
from rp2040py.peripherals.peripheral import BasePeripheral

CSR, DIV, CTR, CC, TOP = 0x00, 0x04, 0x08, 0x0C, 0x10
SLICE_SIZE, SLICES = 0x14, 8
EN = 0xA0
ENABLE, A_INVERTED, B_INVERTED = 1 << 0, 1 << 2, 1 << 3
RESET_VALUES = {CSR: 0, DIV: 1 << 4, CTR: 0, CC: 0, TOP: 0xFFFF}
CYCLE_NS = 8


class Pwm(BasePeripheral):
    """Eight slices. Interrupts and phase-correct counting are not modelled: the firmware uses neither."""

    gpio_value = 0
    gpio_direction = 0

    def __init__(self, rp2040: RP2040) -> None:
        super().__init__(rp2040, "PWM")
        self.reset()

    def reset(self) -> None:
        """Registers of table 4.5.3 after a reset."""
        self._slices = [dict(RESET_VALUES) for _ in range(SLICES)]

    def level(self, pin: int) -> float:
        """Share of time, 0 to 1, in which the slice holds `pin` high; 4.5.2.2: high while the counter is below CC."""
        registers = self._slices[pin >> 1 & 7]
        channel_b = pin & 1
        compare = registers[CC] >> (16 * channel_b) & 0xFFFF
        running = bool(registers[CSR] & ENABLE)
        level = min(1.0, compare / (registers[TOP] + 1)) if running else 0.0
        inverted = registers[CSR] & (B_INVERTED if channel_b else A_INVERTED)
        return 1.0 - level if inverted else level

    def read_uint32(self, offset: int) -> int:
        """A register; the counter runs with the clock."""
        if offset < SLICES * SLICE_SIZE:
            registers = self._slices[offset // SLICE_SIZE]
            register = offset % SLICE_SIZE
            if register == CTR and registers[CSR] & ENABLE:
                steps = int(self.rp2040.clock.nanos / CYCLE_NS * 16 / (registers[DIV] or 0x1000))
                return steps % (registers[TOP] + 1)
            return registers[register]
        if offset == EN:
            return sum((registers[CSR] & ENABLE) << index for index, registers in enumerate(self._slices))
        return 0

    def write_uint32(self, offset: int, value: int) -> None:
        """A register; what a period latches takes effect at once, 50 us early at most."""
        if offset < SLICES * SLICE_SIZE:
            self._slices[offset // SLICE_SIZE][offset % SLICE_SIZE] = value
        elif offset == EN:
            for index, registers in enumerate(self._slices):
                registers[CSR] = registers[CSR] & ~ENABLE | (value >> index & 1)
