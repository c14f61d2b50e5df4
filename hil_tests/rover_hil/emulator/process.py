"""Answers tick requests with the emulated board."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from rover_hil.emulator import wiring
from rover_hil.emulator.board import TICK_CYCLES, Board
from rover_hil.emulator.can_wire import CanWire
from rover_hil.emulator.chip import Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.tick_pipe import REQUEST, Reply, Request
from rover_hil.emulator.wire import SerialWire


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
    start = 0
    while len(data := requests.read(REQUEST.size)) == REQUEST.size:
        request = Request.unpack(data)
        board.apply(request, start)
        if not wire.receive(request.host_bytes_due, start):
            return
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


def _wire(chip: Chip, options: Options) -> SerialWire | CanWire:
    """A board on the serial line has no CAN controller fitted, and one on the bus nothing on its UART."""
    if options.wire == "can":
        return CanWire(chip, options.serial_fd)
    return SerialWire(chip, options.serial_fd, options.baud)
