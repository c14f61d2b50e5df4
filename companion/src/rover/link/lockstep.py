"""The companion's end of a lock-stepped rig: starts its server, moves virtual time, takes frames and marks.

The server is a process of its own in a session of its own: a killed companion or a Ctrl-C in the terminal leaves the
simulated world running, as a killed companion leaves the real one.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.capture.source import RigFrames
from rover.errors import BadInput, LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.link.frames import FrameTransport, SerialFrames
from rover.link.port import CanPort, parse_port
from rover.link.transport import LockstepTransport, Mark

HEADER = struct.Struct("<II")
RigStep = Callable[[int, bytes, bytes, bytes], None]
"""Takes what the rig did in one step that ends at a time in µs: the ticks (request of 40 bytes, reply of 16, for each
millisecond), and the bytes of the wire to and from the firmware."""

START_TIMEOUT = 120.0
"""Seconds for the rig to lay its field and open its port: the heat model of a large field takes its time."""

REPLY_TIMEOUT = 60.0


@dataclass(frozen=True)
class RigOptions:
    """What to start: paths as given by the user, `seed` fixes everything random in the rig.

    `transport`: the wire between companion and firmware, "serial" or "can". `former`: the run whose rover drives on.
    """

    mission: Path
    rig: str = "sitl"
    seed: int = 0
    out: Path | None = None
    data: Path | None = None
    linger: float = 60.0
    free_run: bool = False
    transport: str = "serial"
    former: Path | None = None


class RigProcess:
    """The rig's server. Raises BadInput for what the rig refuses, PreflightFailed when it does not come up."""

    def __init__(self, options: RigOptions, log: Path) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="rover-rig-", ignore_cleanup_errors=True)
        self.control = str(Path(self._folder.name) / "control.sock")
        self.log = log
        with log.open("wb") as messages:
            self._process = subprocess.Popen(
                rig_command(options, self.control),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=messages,
                start_new_session=True,
            )
        try:
            announcement = self._announcement()
        except BaseException:  # Ctrl-C too: nobody else knows of this process yet
            self.stop()
            raise
        device = str(announcement["port"])
        self.port = CanPort("slcan", device).name if options.transport == "can" else device
        self.control = str(announcement["control"])

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._process.pid

    def stop(self, patience: float = 5.0) -> None:
        """Ends the server."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(timeout=patience)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._folder.cleanup()

    def _announcement(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = _read_line(self._process.stdout.fileno(), START_TIMEOUT)
        try:
            announcement = json.loads(line)
            if not {"port", "control"} <= announcement.keys():
                raise ValueError("port or control is missing")
        except (ValueError, AttributeError) as error:
            code = self._wait_briefly()
            said = _last_line(self.log)
            if code == BadInput.exit_code:
                raise BadInput(said) from error
            raise PreflightFailed(f"the rig did not start: {said or 'it said nothing'} (log: {self.log})") from error
        return announcement

    def _wait_briefly(self) -> int | None:
        try:
            return self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            return None


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


def rig_command(options: RigOptions, control: str) -> list[str]:
    """The command line of the rig's server."""
    command = [sys.executable, "-m", "rover_hil", "serve"]
    command += ["--mission", str(options.mission), "--rig", options.rig, "--seed", str(options.seed)]
    command += ["--control", control, "--linger", f"{options.linger:g}"]
    if options.out is not None:
        command += ["--out", str(options.out)]
    if options.data is not None:
        command += ["--data", str(options.data)]
    if options.free_run:
        command.append("--free-run")
    if options.transport != "serial":
        command += ["--wire", options.transport]
    if options.former is not None:
        command += ["--former", str(options.former)]
    return command


def open_lockstep(port: str, baud: int, lead: float) -> tuple[FrameTransport, Callable[[list[Mark]], None]]:
    """A rig's port, and what takes its marks; `lead`: seconds until what is written leaves. Raises PreflightFailed."""
    parsed = parse_port(port)
    if isinstance(parsed, CanPort):
        from rover.link.can_lockstep import LockstepCanTransport  # python-can takes a quarter of a second to import

        bus = LockstepCanTransport(parsed, lead=lead)
        return bus, bus.announce
    line = LockstepTransport(parsed, baud, lead=lead)
    return SerialFrames(line), line.announce


def _connect(control: str) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(REPLY_TIMEOUT)
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


def _read_line(descriptor: int, timeout: float) -> bytes:
    """The first line that comes, without waiting longer than `timeout`; what there is at the end of the stream."""
    line = bytearray()
    deadline = time.monotonic() + timeout
    while b"\n" not in line and (left := deadline - time.monotonic()) > 0:
        if select.select([descriptor], [], [], left)[0]:
            part = os.read(descriptor, 4096)
            if not part:
                break
            line += part
    return bytes(line).partition(b"\n")[0]


def _last_line(file: Path) -> str:
    lines = file.read_text(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""
