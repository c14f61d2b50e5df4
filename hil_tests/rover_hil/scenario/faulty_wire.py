"""The wire between the companion's link and the rig: real bytes on the rig's port, with the scenario's faults on them.

Both kinds are what `rover.link` takes as a transport. `pump` is called once for every step of the world, whether the
companion lives or not: it reads the port, shows everything to the probe, and keeps what is left for the companion.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import Protocol

from rover.link.frames import Frame, FrameTransport
from rover.link.transport import Chunk
from rover.link.wire_around import WireAround
from rover_protocol import framing

from rover_hil.client.line import LockstepTransport
from rover_hil.rig import Mark
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.wire_faults import FROM_FIRMWARE, TO_FIRMWARE, Packet, WireFaults, packets_of, split_frames

HostTime = Callable[[float], float]
"""From the world's time to the companion's own."""


class FaultyWire(Protocol):
    """What the runner needs of either kind."""

    def announce(self, marks: list[Mark]) -> None:
        """Takes the rig's marks."""
        ...

    def pump(self, now: float) -> None:
        """Brings everything forward to `now`."""
        ...

    def restamp(self, now: float) -> None:
        """A companion that was frozen finds everything at once, when it wakes."""
        ...

    @property
    def host_bytes(self) -> int:
        """Bytes that have really gone onto the rig's port."""
        ...

    def close(self) -> None:
        """Lets the port go."""
        ...


class FaultyLine:
    """A serial line."""

    def __init__(self, inner: LockstepTransport, faults: WireFaults, probe: Probe, host_time: HostTime) -> None:
        self._inner = inner
        self._faults = faults
        self._probe = probe
        self._host_time = host_time
        self._inbox: list[Chunk] = []
        self._late: list[tuple[float, int, bytes]] = []
        self._order = 0
        self._now = 0.0
        self._incoming = bytearray()
        self.port = inner.port
        self.byte_time = inner.byte_time
        self.lead = inner.lead
        self.time_step = inner.time_step
        self.bytes_written = 0
        self.bytes_read = 0

    @property
    def host_bytes(self) -> int:
        """See FaultyWire."""
        return self._inner.bytes_written

    def announce(self, marks: list[Mark]) -> None:
        """See FaultyWire."""
        self._inner.announce(marks)

    def write(self, data: bytes) -> None:
        """One frame of the companion."""
        self.bytes_written += len(data)
        for identifier, sequence, payload in packets_of(data):
            for packet in self._faults.frames((identifier, payload), TO_FIRMWARE):
                self._order += 1
                due = self._now + self._faults.delay(packet)
                # Sequences of duplicates and of what was held back are those of the frame that set them free: the
                # receiver counts no gap for what is not lost.
                wire = data if packet == (identifier, payload) else framing.encode(packet[0], sequence, packet[1])
                heapq.heappush(self._late, (due, self._order, wire))
        self._send_due()

    def read(self) -> list[Chunk]:
        """What has come for the companion."""
        chunks, self._inbox = self._inbox, []
        self.bytes_read += sum(len(data) for _, data in chunks)
        return chunks

    def pump(self, now: float) -> None:
        """See FaultyWire."""
        elapsed, self._now = now - self._now, now
        self._send_due()
        self._transmit(self._faults.noise(elapsed, TO_FIRMWARE))
        self._deliver(now, self._faults.noise(elapsed, FROM_FIRMWARE))
        for time, data in self._inner.read():
            self._probe.feed(time, data)
            for wire in split_frames(self._incoming, data):
                for identifier, sequence, payload in packets_of(wire):
                    for packet in self._faults.frames((identifier, payload), FROM_FIRMWARE):
                        sound = framing.encode(packet[0], sequence, packet[1])
                        self._deliver(time, self._faults.spoil(sound, FROM_FIRMWARE))

    def restamp(self, now: float) -> None:
        """See FaultyWire."""
        self._inbox = [(self._host_time(now), data) for _, data in self._inbox]

    def close(self) -> None:
        """See FaultyWire."""
        self._inner.close()

    def _send_due(self) -> None:
        while self._late and self._late[0][0] <= self._now + 1e-9:
            self._transmit(self._faults.spoil(heapq.heappop(self._late)[2], TO_FIRMWARE))

    def _transmit(self, data: bytes) -> None:
        if data:
            self._inner.write(data)

    def _deliver(self, time: float, data: bytes) -> None:
        if data:
            self._inbox.append((self._host_time(time), data))


class FaultyBus(WireAround):
    """A CAN bus."""

    def __init__(self, inner: FrameTransport, announce: Callable[[list[Mark]], None], faults: WireFaults, probe: Probe,
                 host_time: HostTime) -> None:  # fmt: skip
        super().__init__(inner)
        self._announce = announce
        self._faults = faults
        self._probe = probe
        self._host_time = host_time
        self._inbox: list[Frame] = []
        self._late: list[tuple[float, int, Packet]] = []
        self._order = 0
        self._now = 0.0
        self.lead = inner.lead
        self.last_heard = None

    @property
    def host_bytes(self) -> int:
        """See FaultyWire."""
        return self.inner.bytes_written

    def announce(self, marks: list[Mark]) -> None:
        """See FaultyWire."""
        self._announce(marks)

    def send(self, identifier: int, payload: bytes) -> None:
        """See FrameTransport."""
        for packet in self._faults.frames((identifier, payload), TO_FIRMWARE):
            self._order += 1
            heapq.heappush(self._late, (self._now + self._faults.delay(packet), self._order, packet))
        self._send_due()

    def receive(self) -> list[Frame]:
        """See FrameTransport."""
        frames, self._inbox = self._inbox, []
        if frames:
            self.last_heard = frames[-1].time
        return frames

    def pump(self, now: float) -> None:
        """See FaultyWire."""
        self._now = now
        self._send_due()
        for frame in self.inner.receive():
            self._probe.take(frame.time, frame.identifier, frame.payload)
            for identifier, payload in self._faults.frames((frame.identifier, frame.payload), FROM_FIRMWARE):
                self._inbox.append(Frame(self._host_time(frame.time), identifier, payload))

    def restamp(self, now: float) -> None:
        """See FaultyWire."""
        at = self._host_time(now)
        self._inbox = [Frame(at, frame.identifier, frame.payload) for frame in self._inbox]

    def _send_due(self) -> None:
        while self._late and self._late[0][0] <= self._now + 1e-9:
            self.inner.send(*heapq.heappop(self._late)[2])
