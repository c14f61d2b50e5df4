"""The rover's serial port as a pseudo-terminal: the companion opens the slave by name, the rig holds the master."""

from __future__ import annotations

import array
import contextlib
import fcntl
import os
import select
import termios
import tty

# Bytes that may wait for a reader before a free-running rig throws them away, as a wire without a listener does.
MAX_UNREAD_BYTES = 2048


class PseudoTerminal:
    """A raw pty. Its own slave descriptor stays open, so that a companion may come and go without a hang-up."""

    def __init__(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(self._slave)
        self._backlog = bytearray()

    def read(self, limit: int) -> bytes:
        """Up to `limit` bytes that the companion has written; empty when there are none now."""
        try:
            return os.read(self._master, limit)
        except BlockingIOError:
            return b""

    def read_exactly(self, count: int, timeout: float) -> bytes:
        """`count` bytes, or fewer when they do not come within `timeout` seconds of silence."""
        data = bytearray()
        while len(data) < count:
            part = self.read(count - len(data))
            if part:
                data += part
            elif not select.select([self._master], [], [], timeout)[0]:
                break
        return bytes(data)

    def write(self, data: bytes) -> None:
        """Sends to the companion; what the terminal has no room for now goes out with the next write."""
        self._backlog += data
        while self._backlog:
            try:
                sent = os.write(self._master, self._backlog)
            except BlockingIOError:
                return
            del self._backlog[:sent]

    def drop_unread(self, limit: int = MAX_UNREAD_BYTES) -> None:
        """Throws away what waits for the companion's reading when it is more than `limit` bytes."""
        waiting = array.array("i", [0])
        fcntl.ioctl(self._slave, termios.FIONREAD, waiting)
        if waiting[0] > limit or self._backlog:
            self._backlog.clear()
            termios.tcflush(self._slave, termios.TCIFLUSH)

    def close(self) -> None:
        """Hangs up: a companion that reads the port sees its end."""
        for descriptor in (self._slave, self._master):
            if descriptor >= 0:
                with contextlib.suppress(OSError):
                    os.close(descriptor)
        self._master = self._slave = -1
