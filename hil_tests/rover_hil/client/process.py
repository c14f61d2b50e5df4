"""Starts a lock-stepped rig for a companion.

The server is a process of its own in a session of its own: a killed companion or a Ctrl-C in the terminal leaves the
simulated world running, as a killed companion leaves the real one.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from rover.errors import BadInput, PreflightFailed
from rover.link.port import CanPort
from rover.link.rig import RigOptions, RigStep

from rover_hil.client.rig import LockstepRig

# For the rig to lay its field and open its port: the heat model of a large field takes its time.
START_TIMEOUT_S = 120.0

# For a rig that has announced nothing to end.
EXIT_TIMEOUT_S = 2.0


def start(options: RigOptions, log: Path) -> RigProcess:
    """The entry point of the simulated rigs, see `rover.link.rig.start_rig`."""
    return RigProcess(options, log)


class RigProcess:
    """The rig's server. Raises BadInput for what the rig refuses, PreflightFailed when it does not come up."""

    def __init__(self, options: RigOptions, log: Path) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="rover-rig-", ignore_cleanup_errors=True)
        self.control = str(Path(self._folder.name) / "control.sock")
        self.log = log
        with log.open("wb") as messages:
            self._process = subprocess.Popen(
                rig_command(options, self.control),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=messages,
                start_new_session=True,
            )
        try:
            announcement = self._announcement()
        except BaseException:  # Ctrl-C too: nobody else knows of this process yet
            self.stop()
            raise
        device = str(announcement["port"])
        self.port = CanPort("slcan", device).name if options.transport == "can" else device
        self.control = str(announcement["control"])

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._process.pid

    def connect(self, baud: int, pipeline: float = 0.0, on_step: RigStep | None = None) -> LockstepRig:
        """The companion's end, see `rover.link.rig.StartedRig`."""
        return LockstepRig(self.port, self.control, baud, pipeline, on_step)

    def stop(self, patience: float = 5.0) -> None:
        """Ends the server."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(timeout=patience)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._folder.cleanup()

    def _announcement(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = _read_line(self._process.stdout.fileno(), START_TIMEOUT_S)
        try:
            announcement: dict[str, Any] = json.loads(line)
            if not {"port", "control"} <= announcement.keys():
                raise ValueError("port or control is missing")
        except (ValueError, AttributeError) as error:
            code = self._wait_briefly()
            said = _last_line(self.log)
            if code == BadInput.exit_code:
                raise BadInput(said) from error
            raise PreflightFailed(f"the rig did not start: {said or 'it said nothing'}") from error
        return announcement

    def _wait_briefly(self) -> int | None:
        try:
            return self._process.wait(timeout=EXIT_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            return None


def rig_command(options: RigOptions, control: str) -> list[str]:
    """The command line of the rig's server."""
    command = [sys.executable, "-m", "rover_hil", "serve"]
    command += ["--mission", str(options.mission), "--rig", options.rig, "--seed", str(options.seed)]
    command += ["--control", control, "--linger", f"{options.linger:g}"]
    if options.out is not None:
        command += ["--out", str(options.out)]
    if options.data is not None:
        command += ["--data", str(options.data)]
    if options.transport != "serial":
        command += ["--wire", options.transport]
    if options.former is not None:
        command += ["--former", str(options.former)]
    return command


def _read_line(descriptor: int, timeout: float) -> bytes:
    """The first line that comes, without waiting longer than `timeout`; what there is at the end of the stream."""
    line = bytearray()
    deadline = time.monotonic() + timeout
    while b"\n" not in line and (left := deadline - time.monotonic()) > 0:
        if select.select([descriptor], [], [], left)[0]:
            part = os.read(descriptor, 4096)
            if not part:
                break
            line += part
    return bytes(line).partition(b"\n")[0]


def _last_line(file: Path) -> str:
    lines = file.read_text(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""
