"""The firmware's core as a desktop process: where its binary is, how it is started, and its serial wire."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import select
import socket
import subprocess
import sys
from pathlib import Path

from rover.errors import PreflightFailed

ROOT = Path(__file__).resolve().parents[2]
BUILT = ROOT / "target" / "release" / "rover-sitl"
BUILT_ELF = ROOT / "firmware" / "build" / "rover-pico.elf"


def find_binary() -> Path:
    """The rover-sitl to run: $ROVER_SITL, or the one that this repository builds. Raises PreflightFailed."""
    override = os.environ.get("ROVER_SITL")
    binary = Path(override) if override else BUILT
    if not os.access(binary, os.X_OK) or binary.is_dir():
        origin = "from ROVER_SITL" if override else "built by 'make setup'"
        raise PreflightFailed(f"rover-sitl not found at {binary} ({origin}): run 'make setup'")
    return binary


def find_elf() -> Path:
    """Firmware of the emulated board: $ROVER_ELF, or what this repository builds. Raises PreflightFailed."""
    override = os.environ.get("ROVER_ELF")
    elf = Path(override) if override else BUILT_ELF
    if not elf.is_file():
        origin = "from ROVER_ELF" if override else "built by 'make firmware'"
        raise PreflightFailed(f"firmware not found at {elf} ({origin}): run 'make firmware'")
    return elf


def sitl_command() -> list[str]:
    """The core as a desktop process. Raises PreflightFailed."""
    return [str(find_binary())]


def emulator_command() -> list[str]:
    """The emulated board with the firmware that is flashed. Raises PreflightFailed."""
    if importlib.util.find_spec("rp2040py") is None:
        raise PreflightFailed("the emulated board needs the Python package rp2040py: run 'make firmware'")
    return [sys.executable, "-m", "rover_hil.emulator", "--elf", str(find_elf())]


def _arguments(descriptor: int, baud: int, wire: str) -> list[str]:
    arguments = ["--serial-fd", str(descriptor), "--baud", str(baud)]
    return arguments if wire == "serial" else [*arguments, "--wire", wire]


class FirmwareProcess:
    """A running firmware: rover-sitl or the emulated board. Ticks go over its stdin and stdout, serial bytes over one
    end of a socket pair.

    The rig stands between that wire and the pty, so that bytes can be counted, held back or spoiled on the way.
    """

    def __init__(self, program: Path | list[str], baud: int, wire: str = "serial") -> None:
        """`program`: with its first arguments, the wire's are added; `wire`: "serial", or "can": the bytes are then
        slcan's text, a line for each frame."""
        command = [str(program)] if isinstance(program, Path) else program
        self._wire, far_end = socket.socketpair()
        with far_end:
            self._process = subprocess.Popen(
                [*command, *_arguments(far_end.fileno(), baud, wire)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                pass_fds=(far_end.fileno(),),
                start_new_session=True,
            )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.stdin, self.stdout = self._process.stdin, self._process.stdout

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def send(self, data: bytes) -> None:
        """Puts bytes on the wire to the firmware; a process that has ended is noticed at its next tick."""
        with contextlib.suppress(OSError):
            self._wire.sendall(data)

    def receive(self, count: int, timeout: float = 2.0) -> bytes:
        """`count` bytes that the firmware says it has sent; fewer when it has ended."""
        data = bytearray()
        while len(data) < count and select.select([self._wire], [], [], timeout)[0]:
            part = self._wire.recv(count - len(data))
            if not part:
                break
            data += part
        return bytes(data)

    def close(self) -> None:
        """Ends the process: by the end of its stdin, by force when that is not enough."""
        for stream in (self.stdin, self.stdout, self._wire):
            with contextlib.suppress(OSError):
                stream.close()
        try:
            self._process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
