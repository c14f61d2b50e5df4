"""The descriptor between rig and board: bytes that are counted both ways."""

from __future__ import annotations

import contextlib
import os
import select

from rover_protocol.rig_tick import ALL_HOST_BYTES


class Descriptor:
    """Reads up to a total, writes and counts."""

    def __init__(self, number: int) -> None:
        self._number = number
        self._taken = 0
        self.sent = 0

    def read(self, due: int) -> bytes | None:
        """What is missing to a total of `due`, waiting for it; None when the other end hangs up before it has come."""
        data = bytearray()
        while self._taken < due:
            if due == ALL_HOST_BYTES and not select.select([self._number], [], [], 0)[0]:
                break
            part = os.read(self._number, min(4096, due - self._taken))
            if not part:
                return bytes(data) if due == ALL_HOST_BYTES else None
            self._taken += len(part)
            data += part
        return bytes(data)

    def write(self, data: bytes | bytearray) -> None:
        """What is sent to nobody is lost, as on a wire."""
        if data:
            self.sent += len(data)
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                os.write(self._number, data)
