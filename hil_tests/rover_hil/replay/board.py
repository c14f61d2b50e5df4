"""A log of `sitl` on the emulated board: both get the same inputs, their outputs are compared tick by tick.

The board can't get the recorded ticks as they are: its ticks come at times of its own, its converter has steps. So
both are given inputs that mean the same to them, see `rover_hil.emulator.conformance`.
"""

from __future__ import annotations

from dataclasses import asdict

from rover.errors import PreflightFailed
from rover.record.difference import Difference, first_field
from rover.record.rig_step import RigStep

from rover_hil.emulator.tick_pipe import Request
from rover_hil.firmware_process import find_elf, sitl_command
from rover_hil.replay.firmware import REPLIES, Compared
from rover_hil.tick_recorder import Tick


class BoardReplay:
    """Collects the ticks, runs them at the end."""

    def __init__(self, baud: int) -> None:
        """Raises PreflightFailed when emulator, ELF or rover-sitl is missing."""
        try:
            from rover_hil.emulator.conformance import Conformance
        except ImportError as error:
            raise PreflightFailed(
                "the emulated board needs the Python package rp2040py: run 'make setup-dev'"
            ) from error
        self._conformance = Conformance(find_elf(), sitl_command(), baud=baud)
        self._ticks: list[Tick] = []
        self._waiting = bytearray()
        self._due = 0

    def feed(self, step: RigStep) -> None:
        """One step."""
        self._waiting += step.to_firmware
        for data in step.requests:
            request = Request.unpack(data)
            count = request.host_bytes_due - self._due
            self._due = request.host_bytes_due
            self._ticks.append(Tick(request, bytes(self._waiting[:count])))
            del self._waiting[:count]

    def finish(self) -> Compared:
        """Runs all ticks on both; stops at the first that differs."""
        count = 0
        for compared in self._conformance.run(self._ticks):
            if compared.sitl != compared.board:
                found = first_field(asdict(compared.sitl), asdict(compared.board))
                assert found is not None
                return Compared(count, Difference(REPLIES, compared.time_us * 1e-6, *found))
            count += 1
        return Compared(count, None)
