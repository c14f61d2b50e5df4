"""The CAN controller MCP2515 at the level of its registers and SPI instructions (DS20001801)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rover_hil.emulator import mcp2515_registers as regs
from rover_hil.emulator.can_bus import CanBus, Frame

OSCILLATOR_HZ = 16_000_000
PASSIVE_AT, OFF_AT, WARNING_AT = 128, 256, 96
# Recessive bits after which a controller that was off the bus is back (section 6.6).
RECOVERY_BITS = 128 * 11
RESET, READ, WRITE, MODIFY, READ_STATUS, RX_STATUS = 0xC0, 0x03, 0x02, 0x05, 0xA0, 0xB0
READ_RX = {0x90: 0x61, 0x92: 0x66, 0x94: 0x71, 0x96: 0x76}
LOAD_TX = {0x40: 0x31, 0x41: 0x36, 0x42: 0x41, 0x43: 0x46, 0x44: 0x51, 0x45: 0x56}


class Mcp2515:
    """One chip: `select` and `exchange` are its SPI pins, `on_interrupt(asserted)` its INT pin."""

    def __init__(self, clock: Any, bus: CanBus, oscillator: int = OSCILLATOR_HZ) -> None:
        self._bus = bus
        self._oscillator = oscillator
        self._recovery = clock.create_alarm(self._recover)
        self.on_interrupt: Callable[[bool], None] = lambda _asserted: None
        self._asserted = False
        self._command: bytearray | None = None
        self._reset()
        bus.join(self)

    def _reset(self) -> None:
        self.registers = regs.reset_values()
        self._errors = [0, 0]
        self._sending: int | None = None
        self._update()

    @property
    def mode(self) -> int:
        """The mode that CANSTAT shows."""
        return self.registers[regs.CANSTAT] >> 5

    @property
    def bit_rate(self) -> float:
        """From CNF1 to CNF3 (section 5); 0 in the modes without a bus, and off it."""
        if self.mode not in (regs.NORMAL, regs.LISTEN) or self._is_off:
            return 0.0
        cnf1, cnf2, cnf3 = (self.registers[register] for register in (regs.CNF1, regs.CNF2, regs.CNF3))
        propagation, first = (cnf2 & 7) + 1, (cnf2 >> 3 & 7) + 1
        second = (cnf3 & 7) + 1 if cnf2 >> 7 else max(first, 2)
        return self._oscillator / (2 * ((cnf1 & 0x3F) + 1)) / (1 + propagation + first + second)

    @property
    def acknowledges(self) -> bool:
        """Not in listen-only mode."""
        return self.mode == regs.NORMAL

    @property
    def _is_off(self) -> bool:
        return bool(self.registers[regs.EFLG] & regs.BUS_OFF)

    # The bus side.

    def offered(self) -> Frame | None:
        """The pending buffer with the highest priority; of equal ones the highest number (section 3.2)."""
        if self.mode != regs.NORMAL or self._is_off:
            return None
        pending = [n for n in range(3) if self.registers[regs.TX_CONTROL[n]] & regs.TX_REQUEST]
        if not pending:
            return None
        self._sending = max(pending, key=lambda n: (self.registers[regs.TX_CONTROL[n]] & 3, n))
        base = regs.TX_CONTROL[self._sending] + 1
        return regs.frame_of(self.registers[base : base + 13])

    def sent(self, frame: Frame) -> None:
        """Acknowledged: the buffer is free, and the error count goes down."""
        assert self._sending is not None
        self.registers[regs.TX_CONTROL[self._sending]] &= ~(regs.TX_REQUEST | regs.TX_ERROR | regs.LOST_ARBITRATION)
        self.registers[regs.CANINTF] |= regs.TX0_FLAG << self._sending
        self._errors[0] = max(0, self._errors[0] - 1)
        self._update()

    def heard(self, frame: Frame) -> None:
        """Into the buffer whose filter takes it (section 4)."""
        if self._errors[1]:
            self._errors[1] = 119 if self._errors[1] >= PASSIVE_AT else self._errors[1] - 1
        if self.mode in (regs.NORMAL, regs.LISTEN, regs.LOOPBACK):
            self._take(frame)
        self._update()

    def failed(self, transmitting: bool, acknowledged: bool) -> None:
        """An error frame: counters of ISO 11898-1; alone on a bus a passive node counts no further."""
        if transmitting:
            assert self._sending is not None
            control = regs.TX_CONTROL[self._sending]
            self.registers[control] |= regs.TX_ERROR
            if acknowledged or self._errors[0] < PASSIVE_AT:
                self._errors[0] += 8
            if self.registers[regs.CANCTRL] & regs.ONE_SHOT:
                self.registers[control] &= ~regs.TX_REQUEST
        else:
            self._errors[1] = min(255, self._errors[1] + 1)
        self.registers[regs.CANINTF] |= regs.MESSAGE_ERROR_FLAG
        self._update()

    def _take(self, frame: Frame) -> None:
        for number in range(2):
            hit = self._filter_hit(frame, number)
            if hit is None:
                continue
            flags = self.registers[regs.CANINTF]
            target = number
            if number == 0 and flags & regs.RX0_FLAG and self.registers[0x60] & regs.ROLL_OVER:
                target = 1
            if flags & (regs.RX0_FLAG << target):
                self.registers[regs.EFLG] |= regs.RX1_OVERFLOW if target else regs.RX0_OVERFLOW
                self.registers[regs.CANINTF] |= regs.ERROR_FLAG
                return
            control = regs.RX_CONTROL[target]
            hit_bits = 7 if target else 1
            value = self.registers[control] & ~(hit_bits | 1 << 3)
            self.registers[control] = value | (hit & hit_bits) | frame.remote << 3
            content = regs.identifier_bytes(frame) + frame.data
            self.registers[control + 1 : control + 1 + len(content)] = content
            self.registers[regs.CANINTF] |= regs.RX0_FLAG << target
            return

    def _filter_hit(self, frame: Frame, number: int) -> int | None:
        """Number of the filter that takes the frame for that buffer; every frame is taken with RXM = 3."""
        if self.registers[regs.RX_CONTROL[number]] >> 5 & 3 == 3:
            return 2 * number
        mask = self.registers[regs.MASKS[number] : regs.MASKS[number] + 4]
        for index in range(2) if number == 0 else range(2, 6):
            wanted = self.registers[regs.FILTERS[index] : regs.FILTERS[index] + 4]
            if regs.matches(frame, bytes(mask), bytes(wanted)):
                return index
        return None

    def _recover(self) -> None:
        self._errors = [0, 0]
        self._update()
        self._bus.request()

    def _update(self) -> None:
        """What follows from the counters and flags: TEC, REC, EFLG, ICOD and the INT pin."""
        registers = self.registers
        transmit, receive = self._errors
        before = registers[regs.EFLG]
        state = before & (regs.RX0_OVERFLOW | regs.RX1_OVERFLOW)
        state |= regs.RX_WARNING if receive >= WARNING_AT else 0
        state |= regs.TX_WARNING if transmit >= WARNING_AT else 0
        state |= regs.WARNING if max(transmit, receive) >= WARNING_AT else 0
        state |= regs.RX_PASSIVE if receive >= PASSIVE_AT else 0
        state |= regs.TX_PASSIVE if transmit >= PASSIVE_AT else 0
        state |= regs.BUS_OFF if transmit >= OFF_AT else 0
        if state & regs.BUS_OFF and not before & regs.BUS_OFF:
            self._recovery.schedule(RECOVERY_BITS * 1e9 / 500_000)
        if state != before:
            registers[regs.CANINTF] |= regs.ERROR_FLAG
        registers[regs.EFLG] = state
        registers[regs.TEC], registers[regs.REC] = min(255, transmit), min(255, receive)
        active = registers[regs.CANINTF] & registers[regs.CANINTE]
        registers[regs.CANSTAT] = registers[regs.CANSTAT] & 0xE0 | _interrupt_code(active) << 1
        if bool(active) != self._asserted:
            self._asserted = bool(active)
            self.on_interrupt(self._asserted)

    # The SPI side (section 12).

    def select(self, low: bool) -> None:
        """The CS pin: its falling edge begins an instruction, its rising edge ends one."""
        if not low and self._command:
            self._finish(self._command)
        self._command = bytearray() if low else None

    def exchange(self, byte: int) -> int:
        """One byte in, the one that is shifted out meanwhile."""
        if self._command is None:
            return 0xFF
        position = len(self._command)
        self._command.append(byte)
        instruction = self._command[0]
        if position == 0:
            if instruction == RESET:
                self._reset()
            elif instruction & 0xF8 == 0x80:
                self._request_to_send(instruction & 7)
            return 0xFF
        if instruction == READ and position >= 2:
            return self.registers[regs.canonical(self._command[1] + position - 2)]
        if instruction in READ_RX:
            return self.registers[regs.canonical(READ_RX[instruction] + position - 1)]
        if instruction == WRITE and position >= 2:
            self._write(self._command[1] + position - 2, byte)
        elif instruction in LOAD_TX:
            self._write(LOAD_TX[instruction] + position - 1, byte)
        elif instruction == MODIFY and position == 3:
            self._modify(self._command[1], self._command[2], byte)
        elif instruction == READ_STATUS:
            return self._status()
        elif instruction == RX_STATUS:
            return self._rx_status()
        return 0xFF

    def _finish(self, command: bytearray) -> None:
        if command[0] in READ_RX:
            # Reading a buffer frees it when CS rises (12.4).
            self.registers[regs.CANINTF] &= ~(regs.RX0_FLAG << (command[0] >> 2 & 1))
            self._update()

    def _modify(self, address: int, mask: int, value: int) -> None:
        register = regs.canonical(address)
        mask = mask if register in regs.BIT_MODIFIABLE else 0xFF
        self._write(address, self.registers[register] & ~mask | value & mask)

    def _write(self, address: int, value: int) -> None:
        register = regs.canonical(address)
        if register in regs.READ_ONLY or (register in regs.CONFIGURATION_ONLY and self.mode != regs.CONFIGURATION):
            return
        bits = regs.WRITABLE_BITS.get(register, 0xFF)
        self.registers[register] = self.registers[register] & ~bits | value & bits
        if register == regs.CANCTRL:
            self._set_mode(value)
        elif register in regs.TX_CONTROL and value & regs.TX_REQUEST:
            self._request_to_send(1 << regs.TX_CONTROL.index(register))
        self._update()

    def _set_mode(self, control: int) -> None:
        wanted = control >> 5
        if wanted <= regs.CONFIGURATION:
            self.registers[regs.CANSTAT] = wanted << 5
        if control & regs.ABORT_ALL:
            for register in regs.TX_CONTROL:
                if self.registers[register] & regs.TX_REQUEST:
                    self.registers[register] = self.registers[register] & ~regs.TX_REQUEST | regs.ABORTED
        self._bus.request()

    def _request_to_send(self, buffers: int) -> None:
        for number in (n for n in range(3) if buffers >> n & 1):
            control = regs.TX_CONTROL[number]
            kept = self.registers[control] & ~(regs.ABORTED | regs.LOST_ARBITRATION | regs.TX_ERROR)
            self.registers[control] = kept | regs.TX_REQUEST
            if self.mode == regs.LOOPBACK:
                self._sending = number
                frame = regs.frame_of(self.registers[control + 1 : control + 14])
                self.sent(frame)
                self.heard(frame)
        self._bus.request()

    def _status(self) -> int:
        flags = self.registers[regs.CANINTF]
        status = flags & 3
        for number, control in enumerate(regs.TX_CONTROL):
            status |= (self.registers[control] >> 3 & 1) << (2 + 2 * number)
            status |= (flags >> (2 + number) & 1) << (3 + 2 * number)
        return status

    def _rx_status(self) -> int:
        flags = self.registers[regs.CANINTF] & 3
        if not flags:
            return 0
        control = 0x60 if flags & 1 else 0x70
        extended = self.registers[control + 2] >> 3 & 1
        remote = self.registers[control] >> 3 & 1
        hit = self.registers[control] & (1 if control == 0x60 else 7)
        return flags << 6 | extended << 4 | remote << 3 | hit


def _interrupt_code(active: int) -> int:
    """ICOD of CANSTAT: the most important of the interrupts (register 10-2)."""
    order = (regs.ERROR_FLAG, regs.WAKE_FLAG, 1 << 2, 1 << 3, 1 << 4, regs.RX0_FLAG, regs.RX1_FLAG)
    return next((code for code, flag in enumerate(order, 1) if active & flag), 0)
