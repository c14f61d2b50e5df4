"""A unix socket that takes one JSON object a line from any number of clients and answers each with one."""

from __future__ import annotations

import contextlib
import json
import select
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rover.errors import PreflightFailed

MAX_LINE_BYTES = 1 << 20
Answer = Callable[[dict[str, Any]], dict[str, Any]]
"""From a request to its reply; raises ValueError for what cannot be done."""


class ControlSocket:
    """Listens at `path` until closed. Raises PreflightFailed when it cannot."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._clients: dict[socket.socket, bytearray] = {}
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            path.unlink(missing_ok=True)
            self._listener.bind(str(path))
        except OSError as error:
            self._listener.close()
            raise PreflightFailed(f"--control {path}: cannot listen there: {error.strerror or error}") from error
        self._listener.listen(4)

    def serve(self, answer: Answer, timeout_s: float) -> None:
        """Answers what has come; waits for at most so long when nothing has."""
        for ready in select.select([self._listener, *self._clients], [], [], timeout_s)[0]:
            if ready is self._listener:
                client, _ = self._listener.accept()
                client.setblocking(False)
                self._clients[client] = bytearray()
            else:
                self._read(ready, answer)

    def close(self) -> None:
        """Hangs up; takes the socket away."""
        for client in list(self._clients):
            self._drop(client)
        self._listener.close()
        self._path.unlink(missing_ok=True)

    def _read(self, client: socket.socket, answer: Answer) -> None:
        try:
            data = client.recv(65_536)
        except OSError:
            data = b""
        waiting = self._clients[client]
        waiting += data
        while (end := waiting.find(b"\n")) >= 0:
            line = bytes(waiting[:end])
            del waiting[: end + 1]
            reply = json.dumps(_reply(line, answer), ensure_ascii=False).encode() + b"\n"
            with contextlib.suppress(OSError):  # a client that does not wait for its answer
                client.sendall(reply)
        if not data or len(waiting) > MAX_LINE_BYTES:
            self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        del self._clients[client]
        client.close()


def _reply(line: bytes, answer: Answer) -> dict[str, Any]:
    try:
        request = json.loads(line)
    except ValueError as error:
        return {"ok": False, "error": f"request: not valid JSON: {error}"}
    if not isinstance(request, dict):
        return {"ok": False, "error": 'request: a JSON object is expected, as {"op": "pause"}'}
    try:
        return {"ok": True, **answer(request)}
    except ValueError as error:
        return {"ok": False, "error": str(error)}
