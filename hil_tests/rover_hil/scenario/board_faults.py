"""The lock-stepped rigs with faults of the board: a loop that hangs, ticks that are missed, a supply that dips."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover_plant import Plant

from rover_hil.emulator import BLOCK_SIGNALS, GROUND_SIGNALS, HANG_SIGNAL
from rover_hil.firmware_process import FirmwareProcess
from rover_hil.rig import Mark
from rover_hil.sitl import EmulatorRig, SitlRig

# Control loop dead to reset by the watchdog, as docs/results/firmware.md has measured it on the RP2040.
WATCHDOG_US = 114_000

TICK_US = 1000
WATCHDOG, BROWN_OUT = "watchdog", "brown-out"


@dataclass(frozen=True)
class Outage:
    """The firmware does not run until `until_us`. `reset`: why it starts anew then, None when it goes on."""

    until_us: int
    reset: str | None
    powered: bool


class FaultyRig(SitlRig):
    """A rig whose board can be made to fail."""

    def __init__(
        self, plant: Plant, camera: dict[str, Any], baud: int, wire: str, memory: Path | None = None
    ) -> None:
        super().__init__(plant, camera, baud, wire, memory)
        self._baud = baud
        self._wire_kind = wire
        self._outage: Outage | None = None

    def hang(self) -> None:
        """The loop stops; bridges stay as they are until the watchdog resets the board."""
        self._outage = Outage(self.now_us + WATCHDOG_US, WATCHDOG, powered=True)

    def stall(self, duration: float) -> None:
        """The loop misses its ticks for `duration` seconds and goes on; longer than the watchdog allows is a hang."""
        lasting_us = round(duration * 1e6)
        if lasting_us >= WATCHDOG_US:
            self.hang()
        else:
            self._outage = Outage(self.now_us + lasting_us, None, powered=True)

    def brown_out(self, duration: float) -> None:
        """Supply too low for `duration` seconds: the bridges open at once, then the firmware boots."""
        self._outage = Outage(self.now_us + round(duration * 1e6), BROWN_OUT, powered=False)

    def short_interrupt(self, on: bool) -> None:
        """Only of a board with pins."""
        raise NotImplementedError

    def drop_unread(self) -> None:
        """Throws away what the firmware sends and nobody reads any more."""
        self._pty.drop_unread()

    def _run(self, to_us: int, data: bytes) -> list[Mark]:
        outage = self._outage
        if outage is None:
            return super()._run(to_us, data)
        self._from_host += len(data)
        if outage.reset is None:
            self._process.send(data)  # its buffers take what comes
        left, right, powered = self._plant.duty()
        while self.now_us + TICK_US <= min(to_us, outage.until_us):
            self._plant.step(left, right, powered and outage.powered)
        if self.now_us < outage.until_us:
            return []
        self._outage = None
        if outage.reset is not None:
            self._restart(outage.reset)
        return super()._run(to_us, b"")

    def _restart(self, cause: str) -> None:
        self._plant.detach_sitl()
        self._process.close()
        self._process = FirmwareProcess(self._restart_command(cause), self._baud, self._wire_kind)
        self._plant.attach_sitl(self._process.stdin.fileno(), self._process.stdout.fileno(), self._from_host)

    def _restart_command(self, cause: str) -> list[str]:
        return [*self._program(), "--reset-cause", cause]


class FaultyEmulatorRig(FaultyRig, EmulatorRig):
    """The same around the emulated board, whose watchdog resets it by itself."""

    _blocked_until_us: int | None = None

    def hang(self) -> None:
        """The loop's tick does not come any more."""
        os.kill(self.firmware_pid, HANG_SIGNAL)

    def stall(self, duration: float) -> None:
        """The loop's tick comes late; the watchdog of the board decides whether that is too long for it."""
        os.kill(self.firmware_pid, BLOCK_SIGNALS[0])
        self._blocked_until_us = self.now_us + round(duration * 1e6)

    def short_interrupt(self, on: bool) -> None:
        """INT of the CAN controller lies on ground."""
        os.kill(self.firmware_pid, GROUND_SIGNALS[0 if on else 1])

    def _run(self, to_us: int, data: bytes) -> list[Mark]:
        until = self._blocked_until_us
        if until is None or to_us < until:
            return super()._run(to_us, data)
        marks = super()._run(until, data)
        os.kill(self.firmware_pid, BLOCK_SIGNALS[1])
        self._blocked_until_us = None
        return marks + super()._run(to_us, b"")

    def _restart_command(self, cause: str) -> list[str]:
        # The chip sees a supply that comes back as it sees one that comes for the first time.
        return self.command()


FAULTY_RIGS: dict[str, type[FaultyRig]] = {"sitl": FaultyRig, "emulator": FaultyEmulatorRig}
