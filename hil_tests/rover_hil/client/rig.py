"""The companion's end of a lock-stepped rig: moves virtual time, takes frames and marks."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Callable, Sequence
from typing import Any

from rover.errors import LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.link.frames import FrameTransport, SerialFrames
from rover.link.port import CanPort, parse_port
from rover.link.rig import RigStep

from rover_hil.client.frames import RigFrames
from rover_hil.client.line import LockstepTransport
from rover_hil.rig import Mark

HEADER = struct.Struct("<II")
REPLY_TIMEOUT_S = 60.0


class LockstepRig:
    """Virtual time and everything that comes with it. Is the `Clock` of a lock-stepped mission.

    transport: the link with virtual times, serial or CAN as the port says. frames: pictures of the camera, until taken.

    With a `pipeline` step (seconds) the world runs one step ahead while the companion works on the last one, on the
    other core: what is written now leaves at the end of that step, as if the work had taken that long.
    """

    def __init__(
        self,
        port: str,
        control: str,
        baud: int = DEFAULT_BAUD,
        pipeline: float = 0.0,
        on_step: RigStep | None = None,
    ) -> None:
        """`on_step`: takes what enters and leaves the firmware, step by step."""
        # Before the world has begun to run ahead, what is written leaves at once.
        self.transport, self._announce = open_lockstep(port, baud, lead=0.0)
        self._on_step = on_step
        self._pipeline_us = round(pipeline * 1e6)
        self._running_to_us: int | None = None
        self.frames = RigFrames()
        self._socket = _connect(control)
        hello, _ = self._ask({"op": "hello", "record": on_step is not None})
        self.camera: dict[str, Any] = dict(hello.get("camera") or {})
        self.name = str(hello.get("rig", ""))
        self._now_us = int(hello["now_us"])

    @property
    def now_us(self) -> int:
        """Virtual time in µs."""
        return self._now_us

    def now(self) -> float:
        """Virtual time in seconds."""
        return self._now_us * 1e-6

    def next_cycle(self, period: float) -> float:
        """A period from now: virtual time is never late."""
        return self.now() + period

    def advance(self, to: float) -> None:
        """Lets the world run until `to` (whole microseconds); everything written so far is on the wire by then."""
        to_us = round(to * 1e6)
        while self._now_us < to_us:
            if self._running_to_us is None:
                self._run(to_us)
            self._arrive()
        if self._pipeline_us and self._running_to_us is None:
            self._run(self._now_us + self._pipeline_us)
            self.transport.lead = self._pipeline_us * 1e-6

    def _run(self, to_us: int) -> None:
        """Sets the world going; `_arrive` waits for it."""
        self._send({"op": "advance", "to_us": to_us, "host_bytes": self.transport.bytes_written})
        self._running_to_us = to_us

    def _arrive(self) -> None:
        reply, pixels = self._reply()
        self._running_to_us = None
        self._now_us = int(reply["now_us"])
        self._announce([(int(at), int(total)) for at, total in reply["marks"]])
        if self._on_step is not None:
            pixels = self._hand_over(reply.get("recorded", (0, 0, 0)), pixels)
        self.frames.accept(reply["frames"], pixels)

    def _hand_over(self, lengths: Sequence[int], blob: bytes) -> bytes:
        """Gives the last parts of the blob to `on_step`; what is before them are the frames' pixels."""
        assert self._on_step is not None
        ticks, to_firmware, from_firmware = (int(length) for length in lengths)
        pixels = len(blob) - ticks - to_firmware - from_firmware
        first, second = pixels + ticks, pixels + ticks + to_firmware
        self._on_step(self._now_us, blob[pixels:first], blob[first:second], blob[second:])
        return blob[:pixels]

    def finish(self, zones: Sequence[dict[str, Any]] = (), detections: Sequence[dict[str, Any]] = ()) -> dict[str, Any]:
        """Ends the mission for the rig; returns what its referee saw. The rig writes its truth files."""
        if self._running_to_us is not None:
            self._arrive()
        reply, _ = self._ask({"op": "finish", "zones": list(zones), "detections": list(detections)})
        return reply

    def close(self) -> None:
        """Lets go of port and control socket. Without `finish` the rig goes on by itself."""
        self._socket.close()
        self.transport.close()

    def _ask(self, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        self._send(request)
        return self._reply()

    def _send(self, request: dict[str, Any]) -> None:
        header = json.dumps(request, separators=(",", ":")).encode()
        try:
            self._socket.sendall(HEADER.pack(len(header), 0) + header)
        except OSError as error:
            raise LinkLost(f"link lost: the rig is gone ({error.strerror or error})") from error

    def _reply(self) -> tuple[dict[str, Any], bytes]:
        try:
            lengths = HEADER.unpack(_receive(self._socket, HEADER.size))
            reply = json.loads(_receive(self._socket, lengths[0]))
            blob = _receive(self._socket, lengths[1])
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise LinkLost(f"link lost: the rig is gone ({why})") from error
        if "error" in reply:
            raise LinkLost(f"link lost: the rig: {reply['error']}")
        return reply, blob


def open_lockstep(port: str, baud: int, lead: float) -> tuple[FrameTransport, Callable[[list[Mark]], None]]:
    """A rig's port, and what takes its marks; `lead`: seconds until what is written leaves. Raises PreflightFailed."""
    parsed = parse_port(port)
    if isinstance(parsed, CanPort):
        from rover_hil.client.bus import LockstepBus  # python-can takes a quarter of a second to import

        bus = LockstepBus(parsed, lead=lead)
        return bus, bus.announce
    line = LockstepTransport(parsed, baud, lead=lead)
    return SerialFrames(line), line.announce


def _connect(control: str) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(REPLY_TIMEOUT_S)
    try:
        connection.connect(control)
    except OSError as error:
        connection.close()
        raise PreflightFailed(f"cannot reach the rig at {control}: {error.strerror or error}") from error
    return connection


def _receive(connection: socket.socket, count: int) -> bytes:
    data = bytearray()
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            raise ConnectionResetError("it closed the connection")
        data += part
    return bytes(data)
