"""A real rover out of a log: the wire's bytes, the pictures and the times that the mission's loop had then.

Is what `rover.link.device.DeviceRig` was when the log was recorded: time comes from the log cycle by cycle, bytes are
read where they were read, and the link breaks where it broke.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from rover.capture.frame import Frame
from rover.errors import BadInput, LinkLost
from rover.link.can_bus import bus_bytes, bus_time
from rover.link.frames import Counters, FrameTransport, SerialFrames
from rover.link.frames import Frame as WireFrame
from rover.link.intake import Cycle, TappedWire
from rover.link.transport import Chunk
from rover.record.log_reader import Log
from rover.record.topics import RIG_LOST

OnArrival = Callable[[int], None]


class RecordedDevice:
    """Is a `rover.mission.loop.MissionRig`. Raises BadInput when the log holds no cycles.

    recorded: what came in in this cycle then; cycle: what the replay has done in it so far.
    """

    def __init__(self, log: Log, on_arrival: OnArrival) -> None:
        """`on_arrival` is called with each time, µs, that the companion reaches: there it may be paced."""
        self._log = log
        self._on_arrival = on_arrival
        self._cycles = log.cycles()
        first = next(self._cycles, None)
        if first is None:
            raise BadInput(f"{log.path}: the log of a real rover, with nothing of its wire in it")
        self.recorded = first
        self.cycle = Cycle(first.time)
        self.frames_fed = 0
        self._next = next(self._cycles, None)
        self._pictures = log.frames()
        self._picture = next(self._pictures, None)
        origin = log.metadata["mission"]
        inner: FrameTransport
        if origin["transport"] == "can":
            inner = _RecordedBus(self)
        else:
            inner = SerialFrames(_RecordedBytes(self, origin["port"], float(origin["byte_time_s"])))
        self.transport = TappedWire(inner, self)

    def now(self) -> float:
        """Time of the cycle, seconds."""
        return self.recorded.time

    def lead(self) -> float:
        """How far time had gone on when it was asked for."""
        leads = self.recorded.leads
        return leads.pop(0) if leads else 0.0

    def next_cycle(self, period: float) -> float:
        """When the next recorded cycle began."""
        return self._next.time if self._next is not None else self.now() + period

    def advance(self, to: float) -> None:
        """On to the next recorded cycle. Raises LinkLost where the recording ends."""
        if self._next is None:
            raise LinkLost(self._end())
        self.recorded, self._next = self._next, next(self._cycles, None)
        self.cycle = Cycle(self.now())
        self._on_arrival(round(self.now() * 1e6))

    @property
    def frames(self) -> Iterator[Frame]:
        """Pictures that were taken in by the time of this cycle."""
        while self._picture is not None and self._picture.time_ns <= round(self.now() * 1e9):
            header, pixels = self._picture.header, self._picture.pixels
            self._picture = next(self._pictures, None)
            self.frames_fed += 1
            counts = np.frombuffer(pixels, "<u2").reshape(header["height"], header["width"]).astype(np.uint16)
            yield Frame(counts, header["exposure_us"] * 1e-6, header["sequence"], header["ffc"])

    def finish(self, zones: Sequence[dict[str, Any]] = (), detections: Sequence[dict[str, Any]] = ()) -> None:
        """Nobody knows the truth of a real field."""

    def break_link(self, doing: str) -> None:
        """Raises LinkLost where the link broke while `doing`."""
        if self.recorded.failed == doing and self.cycle.sent >= self.recorded.sent:
            raise LinkLost(self.recorded.why)

    def _end(self) -> str:
        lost = next(self._log.messages((RIG_LOST,)), None)
        return json.loads(lost.data)["text"] if lost is not None else "the recording ends here"


class _RecordedBytes:
    """A serial line. Is a `rover.link.transport.Transport`."""

    time_step = 0.0
    lead = 0.0

    def __init__(self, rig: RecordedDevice, port: str, byte_time: float) -> None:
        self.port, self.byte_time = port, byte_time
        self.bytes_written = self.bytes_read = 0
        self._rig = rig

    def write(self, data: bytes) -> None:
        """What the companion sends is compared as messages."""
        self._rig.break_link("send")
        self.bytes_written += len(data)

    def read(self) -> list[Chunk]:
        """The cycle's."""
        self._rig.break_link("receive")
        chunks, self._rig.recorded.chunks = self._rig.recorded.chunks, []
        self.bytes_read += sum(len(data) for _, data in chunks)
        return chunks

    def close(self) -> None:
        """Nothing is open."""


class _RecordedBus(FrameTransport):
    """A CAN bus."""

    port = "a recorded bus"
    time_step = 0.0
    lead = 0.0
    bytes_written = 0
    bytes_read = 0

    def __init__(self, rig: RecordedDevice) -> None:
        self.last_heard = None
        self._rig = rig
        self._received = 0

    @property
    def counters(self) -> Counters:
        """See FrameTransport."""
        return Counters(frames=self._received)

    def wire_bytes(self, payload: int) -> float:
        """As on a real bus."""
        return bus_bytes(payload)

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """By the bit rate."""
        return bus_time(request), bus_time(reply)

    def send(self, identifier: int, payload: bytes) -> None:
        """What the companion sends is compared as messages."""
        self._rig.break_link("send")

    def receive(self) -> list[WireFrame]:
        """The cycle's."""
        self._rig.break_link("receive")
        frames, self._rig.recorded.frames = self._rig.recorded.frames, []
        self._received += len(frames)
        if frames:
            self.last_heard = frames[-1].time
        return frames

    def close(self) -> None:
        """Nothing is open."""
