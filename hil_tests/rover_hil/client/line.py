"""A serial line of a lock-stepped rig: the bytes travel over its pty, and the rig tells when each of them was sent."""

from __future__ import annotations

import time
from collections import deque

from rover.errors import LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.link.claim import Claim
from rover.link.transport import Chunk, close_port, lost, open_port, write_all

from rover_hil.rig import Mark


class LockstepTransport:
    """The rig's pty: bytes are read up to the counts that the rig has announced, so their times are virtual."""

    time_step = 0.001

    def __init__(self, port: str, baud: int = DEFAULT_BAUD, patience: float = 5.0, lead: float = 0.0) -> None:
        """`lead`: seconds after which what is written leaves, see `LockstepRig`."""
        self.port = port
        self.lead = lead
        self.byte_time = 10.0 / baud
        self.bytes_written = 0
        self.bytes_read = 0
        self._patience = patience
        self._claim = Claim(port)
        try:
            self._serial = open_port(port, baud, timeout=patience)
        except PreflightFailed:
            self._claim.release()
            raise
        self._marks: deque[Mark] = deque()

    def announce(self, marks: list[Mark]) -> None:
        """Takes the rig's marks (virtual time in µs, bytes sent so far in all)."""
        self._marks.extend(marks)

    def write(self, data: bytes) -> None:
        """Sends all of `data`; raises `LinkLost`."""
        write_all(self._serial, self.port, data)
        self.bytes_written += len(data)

    def read(self) -> list[Chunk]:
        """One chunk per announced mark; raises `LinkLost` when announced bytes do not come."""
        chunks: list[Chunk] = []
        while self._marks:
            time_us, total = self._marks.popleft()
            wanted = total - self.bytes_read
            if wanted <= 0:
                continue
            data = self._read_exactly(wanted)
            self.bytes_read += wanted
            chunks.append((time_us * 1e-6, data))
        return chunks

    def close(self) -> None:
        """Closes the port."""
        close_port(self._serial)
        self._claim.release()

    def _read_exactly(self, count: int) -> bytes:
        data = bytearray()
        deadline = time.monotonic() + self._patience
        while len(data) < count:
            try:
                data += self._serial.read(count - len(data))
            except (OSError, TypeError, ValueError) as error:
                raise LinkLost(lost(self.port, error)) from error
            if len(data) < count and time.monotonic() > deadline:
                raise LinkLost(f"link lost: {self.port} delivered {len(data)} of {count} bytes that the rig sent")
        return bytes(data)
