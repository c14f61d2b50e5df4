"""The rig's life: in lock step while a companion is there, in real time by itself when there is none."""

from __future__ import annotations

import contextlib
import select
import socket
import time
from pathlib import Path

import numpy as np
from rover.capture.frame import Frame
from rover.capture.publisher import FramePublisher
from rover.errors import PreflightFailed

from rover_hil.rig import Rig, RigFrame
from rover_hil.session import Finish, Session

FREE_STEP = 0.002
"""Seconds of real time between two steps of a free-running rig."""

FIRST_WAIT = 600.0
"""Seconds until a rig that nobody has connected to ends: its companion must have died while starting."""


class Server:
    """Listens on a unix socket for one companion at a time."""

    def __init__(self, rig: Rig, control: Path, finish: Finish, publisher: FramePublisher | None = None) -> None:
        """`publisher`: takes the camera's pictures while the rig runs in real time."""
        self._rig = rig
        self._control = control
        self._finish = finish
        self._publisher = publisher
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            with contextlib.suppress(FileNotFoundError):
                control.unlink()
            self._listener.bind(str(control))
            self._listener.listen(1)
        except OSError as error:
            self._listener.close()
            raise PreflightFailed(f"--control {control}: cannot listen there: {error.strerror or error}") from error

    def run(self, free_run: bool, linger: float) -> None:
        """Serves until a companion has finished, or has been gone for `linger` seconds. Raises RigFailed.

        Without `free_run` time stands still until the first companion comes, which has FIRST_WAIT seconds to.
        """
        if free_run:
            self._run_free(None)
        elif not select.select([self._listener], [], [], FIRST_WAIT)[0]:
            raise PreflightFailed(f"no companion has come to {self._control} within {FIRST_WAIT:g} s")
        while True:
            connection, _ = self._listener.accept()
            with connection:
                if Session(self._rig, self._finish).serve(connection):
                    return
            if not self._run_free(time.monotonic() + linger):
                return

    def _run_free(self, deadline: float | None) -> bool:
        """Real time until a companion comes (True) or the deadline passes (False)."""
        real, virtual_us = time.monotonic(), self._rig.now_us
        while deadline is None or time.monotonic() < deadline:
            elapsed = time.monotonic() - real
            frames = self._rig.advance_free(virtual_us + int(elapsed * 1e6))
            if self._publisher is not None:
                self._publisher.publish(*(self._picture(frame, real - virtual_us * 1e-6) for frame in frames))
            if select.select([self._listener], [], [], FREE_STEP)[0]:
                return True
        return False

    def _picture(self, frame: RigFrame, offset: float) -> Frame:
        """As its camera would give it; `offset`: seconds from virtual time to the system's monotonic clock."""
        size = self._rig.camera["height"], self._rig.camera["width"]
        counts = np.frombuffer(frame.counts, "<u2").reshape(size).astype(np.uint16)
        return Frame(counts, frame.exposure_us * 1e-6 + offset, frame.sequence, frame.ffc)

    def close(self) -> None:
        """Takes the socket away."""
        self._listener.close()
        with contextlib.suppress(OSError):
            self._control.unlink()
        if self._control.parent.name.startswith("rover-rig-"):
            # Made by a companion for this socket alone; one that was killed can't take it away.
            with contextlib.suppress(OSError):
                self._control.parent.rmdir()
