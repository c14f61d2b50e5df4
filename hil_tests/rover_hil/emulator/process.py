"""Answers tick requests with the emulated board."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from rover_protocol.rig_tick import TickRequest

from rover_hil.emulator import BLOCK_SIGNALS, GROUND_SIGNALS, HANG_SIGNAL, wiring
from rover_hil.emulator.board import PHASE_US, TICK_CYCLES, Board
from rover_hil.emulator.can_wire import CanWire
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.tick_pipe import Reply, Request
from rover_hil.emulator.wire import SerialWire

# TIMER_IRQ_1, whose alarm is the control loop's tick (firmware/pico/src/tick.rs).
CONTROL_INTERRUPT = 1


@dataclass(frozen=True)
class Options:
    """What the command line says."""

    serial_fd: int
    baud: int
    wire: str
    elf: Path


def run(options: Options, requests: BinaryIO, replies: BinaryIO) -> None:
    """Ticks until the requests end. Raises BadInput for a bad ELF, RuntimeError when the processor locks up."""
    chip = Chip()
    board = Board(chip)
    wire = _wire(chip, options)
    chip.load(flash_segments(options.elf))
    faults: list[int] = []
    for number in (HANG_SIGNAL, *BLOCK_SIGNALS, *GROUND_SIGNALS):
        signal.signal(number, lambda number, _: faults.append(number))
    # The chip is switched on with the world; its tick number n belongs to the world's millisecond number n.
    start = PHASE_US * CYCLES_PER_US
    while len(data := requests.read(TickRequest.SIZE)) == TickRequest.SIZE:
        request = Request.unpack(data)
        if chip.virtual_clock.cycles < start:
            board.set_levels(request)
            chip.run_until(start)
            board.take_trigger()  # pins that become outputs are no pings
        board.apply(request, start)
        if not wire.receive(request.host_bytes_due, start):
            return
        while faults:
            _begin(chip, faults.pop(0))
        start += TICK_CYCLES
        chip.run_until(start)
        wire.transmit()
        reply = Reply(
            duty=board.duty,
            powered=board.output(wiring.STANDBY),
            led=board.output(wiring.LED),
            buzzer=board.output(wiring.BUZZER),
            trigger=board.take_trigger(),
            bytes_sent=wire.sent,
        )
        replies.write(reply.pack())
        replies.flush()


def _begin(chip: Chip, fault: int) -> None:
    if fault in GROUND_SIGNALS:
        chip.ground(wiring.CAN_INTERRUPT, fault == GROUND_SIGNALS[0])
    elif fault == BLOCK_SIGNALS[1]:
        chip.processor.enable_interrupt(CONTROL_INTERRUPT)
    else:
        # Of a hang the tick never comes again, so nobody feeds the watchdog; what preempts the loop goes on.
        chip.processor.disable_interrupt(CONTROL_INTERRUPT)


def _wire(chip: Chip, options: Options) -> SerialWire | CanWire:
    """A board on the serial line has no CAN controller fitted, and one on the bus nothing on its UART."""
    if options.wire == "can":
        return CanWire(chip, options.serial_fd)
    return SerialWire(chip, options.serial_fd, options.baud)
