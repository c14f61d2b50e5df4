"""The I2C block (Synopsys DW_apb_i2c, RP2040 datasheet 4.3) as a controller: FIFOs, bus timing, interrupts on levels.

rp2040py's transfers take no time, and its levels are cleared by the first read instead of by the FIFO.
"""

from __future__ import annotations

from collections import deque
from typing import Protocol

from rover_plant import Clock
from rp2040py._rp2040 import RP2040
from rp2040py.peripherals.peripheral import BasePeripheral

CON, TAR, DATA_CMD, FS_HCNT, FS_LCNT = 0x00, 0x04, 0x10, 0x1C, 0x20
INTR_STAT, INTR_MASK, RAW_INTR_STAT, RX_TL, TX_TL, CLR_INTR = 0x2C, 0x30, 0x34, 0x38, 0x3C, 0x40
CLR_TX_ABRT, CLR_STOP_DET, CLR_START_DET, ENABLE, STATUS, TXFLR, RXFLR = 0x54, 0x60, 0x64, 0x6C, 0x70, 0x74, 0x78
TX_ABRT_SOURCE, ENABLE_STATUS = 0x80, 0x9C
CLEARS = {CLR_INTR: 0xE4F, CLR_TX_ABRT: 1 << 6, CLR_STOP_DET: 1 << 9, CLR_START_DET: 1 << 10}
"""What reading a register clears."""
RX_FULL, TX_EMPTY, TX_ABRT, STOP_DET, START_DET = 1 << 2, 1 << 4, 1 << 6, 1 << 9, 1 << 10
READ, STOP, RESTART = 1 << 8, 1 << 9, 1 << 10
NO_ADDRESS_ACK, NO_DATA_ACK = 1 << 0, 1 << 3
FIFO_BYTES = 16
BITS_PER_BYTE = 9
# Registers that are only kept.
KEPT = {CON: 0x65, TAR: 0x55, FS_HCNT: 0x06, FS_LCNT: 0x0D, 0x14: 0x28, 0x18: 0x2F, 0x7C: 1, 0xA0: 7, 0x88: 0}


class Target(Protocol):
    """A part on the bus."""

    def start(self, address: int, read: bool) -> bool:
        """A transfer begins: whether it acknowledges."""

    def write(self, byte: int) -> bool:
        """Takes a byte: whether it acknowledges."""

    def read(self) -> int:
        """Gives a byte."""

    @property
    def holds_bus(self) -> bool:
        """Whether it holds the data line low, so that nobody gets anywhere."""


class I2c(BasePeripheral):
    """One block with at most one target."""

    def __init__(self, rp2040: RP2040, clock: Clock, name: str, irq: int) -> None:
        super().__init__(rp2040, name)
        self._irq = irq
        self._clock = clock
        self.target: Target | None = None
        self._byte_alarm = clock.create_alarm(self._next)
        self.reset()

    def reset(self) -> None:
        """Registers after a reset; a transfer under way is lost."""
        self._byte_alarm.cancel()
        self._kept = dict(KEPT)
        self._tx: deque[int] = deque()
        self._rx: deque[int] = deque()
        self._mask, self._latched, self._abort = 0x8FF, 0, 0
        self._rx_level = self._tx_level = 0
        self._enabled = self._addressed = self._reading = False
        self._update()

    @property
    def _byte_ns(self) -> float:
        period = self._kept[FS_HCNT] + self._kept[FS_LCNT]
        return BITS_PER_BYTE * period * 1e9 / self._clock.frequency

    @property
    def _raw(self) -> int:
        level = RX_FULL if len(self._rx) > self._rx_level else 0
        if self._enabled and len(self._tx) <= self._tx_level:
            level |= TX_EMPTY
        return self._latched | level

    def _update(self) -> None:
        self.rp2040.set_interrupt(self._irq, bool(self._raw & self._mask))

    def _go(self) -> None:
        """Begins with what is in the FIFO, unless a byte is on its way."""
        if self._enabled and self._tx and not self._byte_alarm.scheduled:
            self._byte_alarm.schedule(self._byte_ns)

    def _next(self) -> None:
        """A byte's nine bits have passed: an address at first and after a turn, else what the FIFO says."""
        if not self._tx or not self._enabled:
            return
        target = self.target
        if target is not None and target.holds_bus:
            # Arbitration never ends while the line is low: the block waits, and only its user gives up.
            return
        command = self._tx[0]
        read = bool(command & READ)
        if not self._addressed or read != self._reading or command & RESTART:
            self._tx[0] = command & ~RESTART
            self._addressed, self._reading = True, read
            self._latched |= START_DET
            if target is None or not target.start(self._kept[TAR] & 0x7F, read):
                self._give_up(NO_ADDRESS_ACK)
                return
        else:
            self._tx.popleft()
            if read:
                assert target is not None
                self._rx.append(target.read())
            elif target is None or not target.write(command & 0xFF):
                self._give_up(NO_DATA_ACK)
                return
            if command & STOP:
                self._addressed = False
                self._latched |= STOP_DET
        self._update()
        self._go()

    def _give_up(self, reason: int) -> None:
        self._abort |= reason
        self._tx.clear()
        self._addressed = False
        self._latched |= TX_ABRT | STOP_DET
        self._update()

    def read_uint32(self, offset: int) -> int:
        """A register of table 4.3.17."""
        if offset in CLEARS:
            was = bool(self._latched & CLEARS[offset])
            self._latched &= ~CLEARS[offset]
            if CLEARS[offset] & TX_ABRT:
                self._abort = 0
            self._update()
            return int(was)
        if offset == DATA_CMD:
            value = self._rx.popleft() if self._rx else 0
            self._update()
            return value
        values = {
            INTR_STAT: self._raw & self._mask,
            INTR_MASK: self._mask,
            RAW_INTR_STAT: self._raw,
            RX_TL: self._rx_level,
            TX_TL: self._tx_level,
            ENABLE: int(self._enabled),
            ENABLE_STATUS: int(self._enabled),
            TXFLR: len(self._tx),
            RXFLR: len(self._rx),
            TX_ABRT_SOURCE: self._abort,
            STATUS: (bool(self._rx) << 3) | (not self._tx) << 2 | (len(self._tx) < FIFO_BYTES) << 1 | self._addressed,
        }
        return values.get(offset, self._kept.get(offset, 0))

    def write_uint32(self, offset: int, value: int) -> None:
        """A register of table 4.3.17."""
        if offset == DATA_CMD:
            if self._enabled and len(self._tx) < FIFO_BYTES:
                self._tx.append(value & 0x7FF)
                self._go()
        elif offset == INTR_MASK:
            self._mask = value & 0x1FFF
        elif offset == RX_TL:
            self._rx_level = min(value & 0xFF, FIFO_BYTES)
        elif offset == TX_TL:
            self._tx_level = min(value & 0xFF, FIFO_BYTES)
        elif offset == ENABLE:
            self._enabled = bool(value & 1)
            if not self._enabled:
                self._byte_alarm.cancel()
                self._tx.clear()
                self._rx.clear()
                self._addressed = False
        elif offset in self._kept:
            self._kept[offset] = value
        self._update()
