"""An LSM6DSO on the board's I2C bus: its registers (datasheet DS12140), filled with what the plant says."""

from __future__ import annotations

import struct

ADDRESS = 0x6A
"""SA0 low, as on the common breakout boards."""
WHO_AM_I, CTRL1_XL, CTRL2_G, CTRL3_C, OUT_TEMP_L = 0x0F, 0x10, 0x11, 0x12, 0x20
IDENTITY = 0x6C
IF_INC, SW_RESET = 1 << 2, 1 << 0
REGISTERS = 0x80
READ_ONLY = {WHO_AM_I, *range(0x1A, 0x3F)}
# Full scales of the gyroscope in steps of 250 deg/s (FS_G, then FS_125), and of the accelerometer in steps of 2 g.
RATE_SCALES = {0b000: 1.0, 0b010: 2.0, 0b100: 4.0, 0b110: 8.0, 0b001: 0.5}
FELT_SCALES = (1.0, 8.0, 2.0, 4.0)


class Lsm6dso:
    """The part; `show` is what it measures."""

    def __init__(self) -> None:
        self.present = False
        self.holds_bus = False
        self._words: tuple[int, ...] = (0,) * 7
        self._registers = bytearray(REGISTERS)
        self._reset()

    def _reset(self) -> None:
        self._registers[:] = bytes(REGISTERS)
        self._registers[WHO_AM_I] = IDENTITY
        self._registers[CTRL3_C] = IF_INC
        self._pointer: int | None = None

    def show(self, words: tuple[int, ...]) -> None:
        """Temperature, rates and accelerations, (7,), as they are at 250 deg/s and 2 g, in the output registers."""
        self._words = words
        self._fill()

    def _fill(self) -> None:
        felt = FELT_SCALES[self._registers[CTRL1_XL] >> 2 & 3] if self._registers[CTRL1_XL] >> 4 else 0.0
        rate = RATE_SCALES.get(self._registers[CTRL2_G] >> 1 & 7, 1.0) if self._registers[CTRL2_G] >> 4 else 0.0
        scales = (1.0, *(rate,) * 3, *(felt,) * 3)
        values = [round(word / scale) if scale else 0 for word, scale in zip(self._words, scales, strict=True)]
        self._registers[OUT_TEMP_L : OUT_TEMP_L + 14] = struct.pack("<7h", *values)

    def start(self, address: int, read: bool) -> bool:
        """See `Target`."""
        if not read:
            self._pointer = None
        return self.present and address == ADDRESS

    def write(self, byte: int) -> bool:
        """The first byte after an address is the register, the others are for it and those after it."""
        if self._pointer is None:
            self._pointer = byte & 0x7F
            return True
        if self._pointer == CTRL3_C and byte & SW_RESET:
            self._reset()
            self._pointer = CTRL3_C
        elif self._pointer not in READ_ONLY:
            self._registers[self._pointer] = byte
            self._fill()
        self._step()
        return True

    def read(self) -> int:
        """The register that the pointer is at."""
        value = self._registers[self._pointer or 0]
        self._step()
        return value

    def _step(self) -> None:
        if self._registers[CTRL3_C] & IF_INC:
            self._pointer = ((self._pointer or 0) + 1) % REGISTERS
