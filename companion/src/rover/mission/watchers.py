"""Those who look on while a mission is on its way: each is sent what is newest, and nobody is waited for.

The loop hands over a `Moment` a few times a second, which takes as long as copying it. A thread of its own makes
messages of it, each whole in itself, and keeps of each kind the newest for every watcher: one that is slow misses some,
one that takes nothing for SEND_WITHIN_S is let go. Without watchers nothing is copied at all. The times here are the
wall clock's: nothing of this comes back to the mission.
"""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field

from rover.mission.moment import Moment, messages

# Seconds of the wall clock between two moments, and between two maps.
PERIOD_S = 0.2
MAP_PERIOD_S = 1.0
# Maps of more cells are shown less often, in proportion.
MAP_CELLS = 250_000
SEND_WITHIN_S = 10.0


@dataclass
class Watcher:
    """What one of them has not been sent yet, by kind."""

    pending: dict[str, bytes] = field(default_factory=dict)


class Watchers:
    """Those of one mission."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._changed = threading.Condition()
        self._watchers: list[Watcher] = []
        self._newest: dict[str, bytes] = {}
        self._moment: Moment | None = None
        self._thread: threading.Thread | None = None
        self._over = False
        self._next = 0.0
        self._next_map = 0.0

    def due(self) -> bool:
        """True when somebody looks on and has been told nothing for a while. From the mission's loop."""
        return bool(self._watchers) and self._moment is None and time.monotonic() >= self._next

    def map_due(self) -> bool:
        """True when the map is to be shown, too."""
        return time.monotonic() >= self._next_map

    def show(self, moment: Moment) -> None:
        """From the mission's loop; returns at once."""
        now = time.monotonic()
        self._next = now + PERIOD_S
        if moment.layers is not None:
            self._next_map = now + MAP_PERIOD_S * max(1.0, moment.layers.seen.size / MAP_CELLS)
        with self._changed:
            self._moment = moment
            self._changed.notify_all()

    def serve(self, client: socket.socket) -> None:
        """Sends one client all that there is to tell until it goes, or the mission ends. In the client's thread."""
        watcher = Watcher()
        with self._changed:
            if self._over or len(self._watchers) >= self._limit:
                return
            watcher.pending.update(self._newest)
            self._watchers.append(watcher)
            # Whoever comes is shown all of it soon.
            self._next_map = 0.0
            if self._thread is None:
                self._thread = threading.Thread(target=self._tell, name="watchers", daemon=True)
                self._thread.start()
        client.settimeout(SEND_WITHIN_S)
        try:
            while (lines := self._wait(watcher)) is not None:
                client.sendall(lines)
        except OSError:
            return  # gone, or too slow
        finally:
            with self._changed:
                self._watchers.remove(watcher)

    def close(self) -> None:
        """The mission is over: nobody is told anything more."""
        with self._changed:
            self._over = True
            self._changed.notify_all()

    def _wait(self, watcher: Watcher) -> bytes | None:
        """What the watcher has not been sent; None when there will be no more."""
        with self._changed:
            while not watcher.pending:
                if self._over:
                    return None
                self._changed.wait()
            lines = b"".join(watcher.pending.values())
            watcher.pending.clear()
            return lines

    def _tell(self) -> None:
        while True:
            with self._changed:
                while self._moment is None and not self._over:
                    self._changed.wait()
                moment = self._moment
                if moment is None:
                    return
            told: dict[str, bytes] = {}
            with suppress(ValueError, ArithmeticError):  # nobody's picture is worth a mission
                told = messages(moment)
            with self._changed:
                self._moment = None
                self._newest.update(told)
                for watcher in self._watchers:
                    watcher.pending.update(told)
                self._changed.notify_all()
