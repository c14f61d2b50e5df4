"""The rigs in lock step: a firmware process, the plant around it, a pty towards the companion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover_plant import Plant

from rover_hil.firmware_process import FirmwareProcess, emulator_command, sitl_command
from rover_hil.pty import PseudoTerminal
from rover_hil.rig import Advance, Mark, RigFailed, RigFrame

# Firmware bytes are handed on at least this often, so that no buffer on the way fills up.
CHUNK_US = 50_000

# Seconds to wait for bytes that the companion says it has written.
HOST_TIMEOUT_S = 5.0


class SitlRig:
    """Firmware, plant and port in one virtual time; see `rover_hil.rig.Rig`. Raises PreflightFailed, RigFailed."""

    name = "sitl"
    command = staticmethod(sitl_command)
    """The firmware's program with its first arguments."""

    def __init__(
        self, plant: Plant, camera: dict[str, Any], baud: int, wire: str = "serial", memory: Path | None = None
    ) -> None:
        """`memory`: file that the firmware keeps its parameters in, where the rig's board has no flash of its own."""
        self._plant = plant
        self._camera = camera
        self._memory = memory
        self._process = FirmwareProcess(self._program(), baud, wire)
        plant.attach_sitl(self._process.stdin.fileno(), self._process.stdout.fileno())
        self._pty = PseudoTerminal()
        self.port = self._pty.name
        # Totals since the start of the rig, and what they were when the present companion came.
        self._from_host = self._to_host = 0
        self._host_base = self._firmware_base = 0
        self._recording = False
        self._from_firmware = bytearray()

    def _program(self) -> list[str]:
        """The firmware's program with all its arguments."""
        return [*self.command(), *(["--parameters", str(self._memory)] if self._memory is not None else [])]

    @property
    def now_us(self) -> int:
        """Virtual time, µs."""
        return self._plant.now_us

    @property
    def camera(self) -> dict[str, Any]:
        """Name, width, height, period_us, latency_us."""
        return self._camera

    @property
    def firmware_pid(self) -> int:
        """Process id of rover-sitl."""
        return self._process.pid

    def begin_session(self) -> None:
        """The companion that comes now counts from zero; what nobody has read is gone."""
        if self.now_us > 0:
            self._pty.drop_unread(limit=0)
            self._plant.take_frames()
        self._host_base, self._firmware_base = self._from_host, self._to_host

    def record(self) -> None:
        """From here on `Advance` holds ticks and bytes of the wire."""
        self._recording = True
        self._from_firmware.clear()
        self._plant.record_ticks()

    def advance(self, to_us: int, host_bytes: int) -> Advance:
        """Lock step: waits for all the bytes that the companion has written, then runs until `to_us`."""
        wanted = self._host_base + host_bytes - self._from_host
        if wanted < 0:
            raise RigFailed(f"host_bytes went back to {host_bytes}: it counts all bytes since hello")
        data = self._pty.read_exactly(wanted, HOST_TIMEOUT_S)
        if len(data) < wanted:
            raise RigFailed(f"{self.port}: the companion wrote {host_bytes} bytes, {wanted - len(data)} never came")
        marks = self._run(to_us, data)
        frames = tuple(RigFrame(*frame) for frame in self._plant.take_frames())
        shifted = tuple((at, total - self._firmware_base) for at, total in marks)
        if not self._recording:
            return Advance(self.now_us, shifted, frames)
        sent = bytes(self._from_firmware)
        self._from_firmware.clear()
        return Advance(self.now_us, shifted, frames, self._plant.take_ticks(), data, sent)

    def advance_free(self, to_us: int) -> tuple[RigFrame, ...]:
        """Takes what is there, and throws away what nobody reads."""
        self._run(to_us, self._pty.read(4096))
        self._plant.take_ticks()
        self._from_firmware.clear()
        self._pty.drop_unread()
        return tuple(RigFrame(*frame) for frame in self._plant.take_frames())

    def _run(self, to_us: int, data: bytes) -> list[Mark]:
        self._process.send(data)
        self._from_host += len(data)
        marks: list[Mark] = []
        while self.now_us + 1000 <= to_us:
            try:
                marks += self._plant.run_until(min(self.now_us + CHUNK_US, to_us), self._from_host)
            except ConnectionError as error:
                raise RigFailed(f"{error} at {self.now_us * 1e-6:.3f} s") from error
            sent = marks[-1][1] - self._to_host if marks else 0
            if sent > 0:
                received = self._process.receive(sent)
                self._pty.write(received)
                if self._recording:
                    self._from_firmware += received
                self._to_host += sent
        return marks

    def set_emergency_stop(self, active: bool) -> None:
        """Presses or releases the emergency-stop input."""
        self._plant.set_emergency_stop(active)

    def truth(self) -> NDArray[np.float64]:
        """True trajectory (n, 4): time s, x, y, heading."""
        return self._plant.truth()

    def seen(self) -> NDArray[np.bool_]:
        """Ground that the camera has shown, (rows, columns) of 1 cm."""
        return self._plant.seen()[0]

    def verdict(self) -> dict[str, Any]:
        """The plant's referee: collisions, clearances, unseen ground."""
        return self._plant.verdict()

    def close(self) -> None:
        """Hangs up and ends the firmware."""
        self._pty.close()
        self._plant.detach_sitl()
        self._process.close()


class EmulatorRig(SitlRig):
    """The same world around the emulated board, which speaks the same ticks. Raises PreflightFailed, RigFailed."""

    name = "emulator"
    command = staticmethod(emulator_command)

    def _program(self) -> list[str]:
        return self.command()
