"""`rover hil serve` as a process, and a client of its control socket."""

from __future__ import annotations

import json
import select
import signal
import socket
import subprocess
import sys
from typing import Any

START_TIMEOUT_S = 60.0
REPLY_TIMEOUT_S = 20.0


class ServedRig:
    """A rig in real time. `port` and `camera_source` as for `rover run --rig device`."""

    def __init__(self, mission: str, *options: str) -> None:
        """Starts it and waits for its announcement. Raises RuntimeError with what it said when none comes."""
        command = [sys.executable, "-m", "rover.cli.main", "hil", "serve", mission, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        announced = select.select([self.process.stdout], [], [], START_TIMEOUT_S)[0]
        line = self.process.stdout.readline() if announced else b""
        if not line:
            self.process.kill()
            raise RuntimeError(f"the rig did not announce itself: {self.process.stderr.read().decode()}")
        self.announcement: dict[str, Any] = json.loads(line)
        self.port = str(self.announcement["port"])
        self.camera_source = str(self.announcement["camera_source"])
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(REPLY_TIMEOUT_S)
        self._socket.connect(str(self.announcement["control"]))
        self._replies = self._socket.makefile("rb")

    def send(self, line: bytes) -> dict[str, Any]:
        """One line as it is; returns the reply."""
        self._socket.sendall(line + b"\n")
        reply: dict[str, Any] = json.loads(self._replies.readline())
        return reply

    def ask(self, op: str, **values: Any) -> dict[str, Any]:
        """One request that is granted; returns the reply."""
        reply = self.send(json.dumps({"op": op, **values}).encode())
        assert reply["ok"], reply
        return reply

    def refusal(self, op: str, **values: Any) -> str:
        """Why a request is refused."""
        reply = self.send(json.dumps({"op": op, **values}).encode())
        assert not reply["ok"], reply
        return str(reply["error"])

    def stop(self) -> None:
        """Ends it, by force if need be."""
        self._replies.close()
        self._socket.close()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        for stream in (self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()
