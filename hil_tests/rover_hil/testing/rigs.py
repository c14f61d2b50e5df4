"""A rig's server as a process, and the barest client of its control socket."""

from __future__ import annotations

import json
import select
import signal
import socket
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


class Client:
    """A bare client of the control socket: sends a header, returns header and blob."""

    def __init__(self, control: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(20.0)
        self.socket.connect(control)

    def ask(self, **request: Any) -> tuple[dict[str, Any], bytes]:
        """One request, one reply. Raises EOFError when the rig has closed."""
        header = json.dumps(request).encode()
        self.socket.sendall(struct.pack("<II", len(header), 0) + header)
        header_length, blob_length = struct.unpack("<II", self._exactly(8))
        return json.loads(self._exactly(header_length)), self._exactly(blob_length)

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            part = self.socket.recv(count - len(data))
            if not part:
                raise EOFError
            data += part
        return data


@dataclass
class RunningRig:
    """A served rig; `port` is its serial port."""

    process: subprocess.Popen[bytes]
    port: str
    control: str
    _clients: list[Client] = field(default_factory=list)

    def client(self) -> Client:
        """Connects to the control socket."""
        client = Client(self.control)
        self._clients.append(client)
        return client

    @property
    def firmware_pid(self) -> int:
        """The rover-sitl that the rig has started."""
        pid = self.process.pid
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return int(children[0])

    def stop(self) -> None:
        """Ends the rig, by force if need be."""
        for client in self._clients:
            client.socket.close()
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


def rig_command(control: Path, *options: str) -> list[str]:
    """The command line of a rig for the shipped demo mission."""
    return [sys.executable, "-m", "rover_hil", "serve", "--mission", "demo", "--control", str(control), *options]


def start_rig(control: Path, *options: str) -> RunningRig:
    """Starts a rig and waits for its announcement. Raises RuntimeError with what it said when none comes."""
    process = subprocess.Popen(rig_command(control, *options), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    announced = select.select([process.stdout], [], [], 60.0)[0]
    line = process.stdout.readline() if announced else b""
    if not line:
        process.kill()
        raise RuntimeError(f"the rig did not announce itself: {process.stderr.read().decode()}")
    announcement = json.loads(line)
    return RunningRig(process, announcement["port"], announcement["control"])
