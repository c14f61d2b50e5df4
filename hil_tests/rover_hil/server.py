"""The life of a companion's rig: in lock step while the companion is there, in real time when it was lost."""

from __future__ import annotations

import contextlib
import select
import socket
import time
from collections.abc import Callable
from pathlib import Path

from rover.errors import PreflightFailed

from rover_hil.free_run.real_time import RealTime
from rover_hil.rig import Rig
from rover_hil.session import Finish, Session

# Between two steps of a rig in real time.
FREE_STEP_S = 0.002

# Until a rig that nobody has connected to ends: its companion must have died while starting.
FIRST_WAIT_S = 600.0


class Server:
    """Listens on a unix socket for one companion at a time."""

    def __init__(self, rig: Rig, control: Path, finish: Finish, lost: Callable[[], None] = lambda: None) -> None:
        """`lost`: called when a companion has gone without finishing, and when the rig has ended after that."""
        self._rig = rig
        self._control = control
        self._finish = finish
        self._lost = lost
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            with contextlib.suppress(FileNotFoundError):
                control.unlink()
            self._listener.bind(str(control))
            self._listener.listen(1)
        except OSError as error:
            self._listener.close()
            raise PreflightFailed(f"--control {control}: cannot listen there: {error.strerror or error}") from error

    def run(self, linger: float) -> None:
        """Serves until a companion has finished, or has been gone for `linger` seconds. Raises RigFailed.

        Time stands still until the first companion comes, which has FIRST_WAIT_S to.
        """
        if not select.select([self._listener], [], [], FIRST_WAIT_S)[0]:
            raise PreflightFailed(f"no companion has come to {self._control} within {FIRST_WAIT_S:g} s")
        while True:
            connection, _ = self._listener.accept()
            with connection:
                if Session(self._rig, self._finish).serve(connection):
                    return
            self._lost()
            if not self._run_free(time.monotonic() + linger):
                self._lost()
                return

    def _run_free(self, deadline: float) -> bool:
        """Real time until a companion comes (True) or the deadline passes (False)."""
        world = RealTime(self._rig)
        while time.monotonic() < deadline:
            world.step()
            if select.select([self._listener], [], [], FREE_STEP_S)[0]:
                return True
        return False

    def close(self) -> None:
        """Takes the socket away."""
        self._listener.close()
        with contextlib.suppress(OSError):
            self._control.unlink()
        if self._control.parent.name.startswith("rover-rig-"):
            # Made by a companion for this socket alone; one that was killed can't take it away.
            with contextlib.suppress(OSError):
                self._control.parent.rmdir()
