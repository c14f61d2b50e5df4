"""The rover's protocol on a port in real time: sends messages, keeps what comes by the names of the messages."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import serial
from rover.errors import LinkLost
from rover.link.baud import DEFAULT_BAUD
from rover.link.transport import open_port
from rover_protocol import framing, messages

from rover_hil.named_values import named_values

POLL_S = 0.002


class DeviceTalk:
    """An open port. `work` is called again and again while it waits. Raises PreflightFailed, LinkLost."""

    def __init__(self, port: str, baud: int = DEFAULT_BAUD) -> None:
        self.port = port
        self.work: Callable[[], None] = lambda: None
        self._serial: serial.Serial = open_port(port, baud, timeout=0.0)
        self._decoder = framing.Decoder()
        self._sequence = 0
        self._received: dict[str, list[dict[str, Any]]] = {}

    def send(self, name: str, **values: int) -> None:
        """One message of raw values; fields left out are 0."""
        message = messages.BY_NAME[name]
        frame = framing.encode(message.ID, self._sequence, message.pack(**values))
        self._sequence = (self._sequence + 1) & 255
        try:
            self._serial.write(frame)
        except OSError as error:
            raise LinkLost(f"link lost: {self.port}: {os.strerror(error.errno or 0)}") from error

    def receive(self) -> None:
        """Takes in what has come; never waits."""
        try:
            data = self._serial.read(self._serial.in_waiting)
        except OSError as error:
            raise LinkLost(f"link lost: {self.port}: {os.strerror(error.errno or 0)}") from error
        for identifier, _, payload in self._decoder.feed(data):
            try:
                message, values = messages.decode(identifier, payload)
            except ValueError:
                continue
            self._received.setdefault(message.name, []).append(named_values(message, values))

    def wait(self, seconds: float) -> None:
        """Lives on for a while."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._turn()

    def until(self, name: str, wanted: Callable[[dict[str, Any]], bool], seconds: float) -> dict[str, Any]:
        """The first such message that comes from now on. Raises TimeoutError with the last one of that name."""
        known = len(self.all(name))
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._turn()
            for values in self.all(name)[known:]:
                if wanted(values):
                    return values
            known = len(self.all(name))
        last = self.all(name)[-1:] or "none"
        raise TimeoutError(f"{self.port}: no such {name} within {seconds:g} s; the last was {last}")

    def all(self, name: str) -> list[dict[str, Any]]:
        """Messages of that name so far, oldest first: raw values, by their names where the protocol has some."""
        return self._received.get(name, [])

    def forget(self) -> None:
        """What has come so far counts no more."""
        self.receive()
        self._received.clear()

    def close(self) -> None:
        """Lets the port go."""
        self._serial.close()

    def _turn(self) -> None:
        self.receive()
        self.work()
        time.sleep(POLL_S)
