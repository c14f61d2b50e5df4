"""Gives a camera's pictures to whoever connects to a unix socket, in the layout of `rover.capture.camera_socket`."""

from __future__ import annotations

import contextlib
import socket
from pathlib import Path

from rover.capture.camera_socket import pack_frame
from rover.capture.frame import Frame
from rover.errors import PreflightFailed

# Bytes that may wait for a reader before it counts as gone.
MAX_BACKLOG_BYTES = 1 << 20


class FramePublisher:
    """Gives each picture to everyone who is connected, and never waits for any of them.

    Raises PreflightFailed when it can't listen there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._waiting: dict[socket.socket, bytearray] = {}
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            path.unlink(missing_ok=True)
            self._listener.bind(str(path))
        except OSError as error:
            self._listener.close()
            raise PreflightFailed(f"{path}: pictures cannot be published there: {error.strerror or error}") from error
        self._listener.listen(4)
        self._listener.setblocking(False)

    def publish(self, *frames: Frame) -> None:
        """To be called often, also without a picture: what a reader had no room for goes out then."""
        with contextlib.suppress(BlockingIOError):
            reader, _ = self._listener.accept()
            reader.setblocking(False)
            self._waiting[reader] = bytearray()
        data = b"".join(pack_frame(frame) for frame in frames)
        for reader in list(self._waiting):
            self._give(reader, data)

    def close(self) -> None:
        """Hangs up; takes the socket away."""
        for reader in list(self._waiting):
            self._drop(reader)
        self._listener.close()
        with contextlib.suppress(OSError):
            self._path.unlink()

    def _give(self, reader: socket.socket, data: bytes) -> None:
        waiting = self._waiting[reader]
        waiting += data
        try:
            while waiting:
                del waiting[: reader.send(waiting)]
        except BlockingIOError:
            if len(waiting) > MAX_BACKLOG_BYTES:
                self._drop(reader)
        except OSError:
            self._drop(reader)

    def _drop(self, reader: socket.socket) -> None:
        del self._waiting[reader]
        reader.close()
