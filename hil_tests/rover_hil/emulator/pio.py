"""PIO blocks that are stepped when it matters (RP2040 datasheet 3): before an input changes and before a register is
read or written. Between those moments a state machine without outputs sees nothing that could change."""

from __future__ import annotations

from rover_plant import Clock
from rp2040py.peripherals.peripheral import ATOMIC_NORMAL
from rp2040py.peripherals.pio import RPPIO

# rp2040py counts the time of its state machines in 256ths of a cycle.
SUBCYCLES = 256
# Steps within which a program must come back to where it was for its loops to be skipped.
MAX_LOOP = 64
# Loops after a change of an input in which the program sees it and goes back to waiting.
SETTLING = 2


class LazyPio:
    """Stands for one of rp2040py's blocks on the bus.

    With constant inputs a state machine that comes back to the same state goes round for ever, so whole rounds are
    skipped: exact, and the reason why two encoders at 500 kHz cost next to nothing.
    """

    def __init__(self, clock: Clock, block: RPPIO) -> None:
        self._clock = clock
        self._block = block
        self._cycle = 0
        self._loop = 0

    def catch_up(self) -> None:
        """Runs the state machines up to now, at exactly the cycles at which each is due."""
        now = self._clock.cycles
        block = self._block
        missing, self._cycle = now - self._cycle, now
        if block.stopped or not missing:
            return
        end = block.cycle_fp + missing * SUBCYCLES
        if self._loop and missing * SUBCYCLES > (SETTLING + 2) * self._loop:
            self._run(block.cycle_fp + SETTLING * self._loop)
            before = self._state()
            self._run(block.cycle_fp + self._loop)
            if self._state() == before:
                self._skip((end - block.cycle_fp) // self._loop * self._loop)
            else:
                self._loop = 0
        elif not self._loop and missing * SUBCYCLES > MAX_LOOP * SUBCYCLES:
            self._find_loop(end)
        self._run(end)

    def _run(self, end: int) -> None:
        block = self._block
        advance = block.advance
        while (due := block.next_due_fp) <= end:
            step = -((block.cycle_fp - due) // SUBCYCLES)
            advance(step if step > 1 else 1)
        advance((end - block.cycle_fp) // SUBCYCLES)

    def _find_loop(self, end: int) -> None:
        """Length of the loop in which the machines are now; 0 when there is none, or not within reach."""
        block = self._block
        self._run(min(end, block.next_due_fp))
        begin, state = block.cycle_fp, self._state()
        for _ in range(MAX_LOOP):
            if block.next_due_fp > end:
                return
            self._run(block.next_due_fp)
            if self._state() == state:
                self._loop = block.cycle_fp - begin
                return

    def _state(self) -> tuple[object, ...]:
        """Everything that decides how the block goes on, relative to now. Of FIFOs the levels: nobody else takes
        anything out meanwhile, and what is pushed into a full one is dropped."""
        block = self._block
        state: list[object] = [block.irq, block.pin_values, block.pin_directions]
        for machine in block.machines:
            if machine.enabled:
                state += (
                    machine.next_due_fp - block.cycle_fp if not machine.waiting else None,
                    machine.pc,
                    machine.x,
                    machine.y,
                    machine.input_shift_reg,
                    machine.input_shift_count,
                    machine.output_shift_reg,
                    machine.output_shift_count,
                    machine.exec_valid,
                    machine.rx_fifo.item_count,
                    machine.tx_fifo.item_count,
                )
        return tuple(state)

    def _skip(self, duration: int) -> None:
        block = self._block
        for machine in block.machines:
            if machine.enabled and not machine.waiting:
                machine.next_due_fp += duration
        block.cycle_fp += duration
        block.recompute_due()

    def read_uint32(self, offset: int) -> int:
        """A register."""
        self.catch_up()
        return self._block.read_uint32(offset)

    def write_uint32(self, offset: int, value: int) -> None:
        """A register."""
        self.write_uint32_atomic(offset, value, ATOMIC_NORMAL)

    def write_uint32_atomic(self, offset: int, value: int, kind: int) -> None:
        """A register, or one of its aliases."""
        self.catch_up()
        self._loop = 0
        self._block.write_uint32_atomic(offset, value, kind)

    def reset(self) -> None:
        """As the block's own."""
        self._block.reset()
