"""The control socket of a simulated rig, found by the rig's port."""

from __future__ import annotations

import json
import socket
import tempfile
from pathlib import Path
from typing import Any

from rover.errors import BadInput, LinkLost

TIMEOUT_S = 30.0


def control_of(port: str) -> Path | None:
    """Where `rover hil serve` on this machine listens that has this port; None for a real board."""
    for note in sorted(Path(tempfile.gettempdir()).glob("rover-rig-*/rig.json")):
        try:
            told = json.loads(note.read_text(encoding="utf-8"))
            if told["port"] == port:
                return Path(told["control"])
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


class RigControl:
    """Sends requests and returns replies; docs/reference/simulation.md lists them."""

    def __init__(self, path: Path) -> None:
        """Raises BadInput when nobody listens there."""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(TIMEOUT_S)
        try:
            self._socket.connect(str(path))
        except OSError as error:
            self._socket.close()
            raise BadInput(f"{path}: no rig answers there: {error.strerror or error}") from None
        self._replies = self._socket.makefile("rb")

    def __call__(self, request: dict[str, Any]) -> dict[str, Any]:
        """One request. Raises BadInput with the rig's reason, LinkLost when it has gone."""
        try:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
            line = self._replies.readline()
        except OSError as error:
            raise LinkLost(f"the rig's control socket: {error}") from None
        if not line:
            raise LinkLost("the rig has gone")
        reply: dict[str, Any] = json.loads(line)
        if not reply.get("ok"):
            raise BadInput(f"the rig refuses {request.get('op')}: {reply.get('error')}")
        return reply

    def close(self) -> None:
        """Lets go of it."""
        self._replies.close()
        self._socket.close()
