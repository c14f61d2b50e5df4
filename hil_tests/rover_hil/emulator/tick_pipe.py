"""One millisecond on the pipes, as rover-sitl speaks it: a request of 40 bytes, a reply of 16, little-endian."""

from __future__ import annotations

import struct
from dataclasses import dataclass

REQUEST = struct.Struct("<QiiIHBBQBxxxI")
REPLY = struct.Struct("<hhBBxxQ")
NO_SENSOR = 255
EVERYTHING = 2**64 - 1
"""`host_bytes_due` of a caller that does not count: whatever is there."""


@dataclass(frozen=True)
class Request:
    """The world at `now_us`."""

    now_us: int
    counts: tuple[int, int]
    battery_mv: int
    emergency_stop: bool
    host_bytes_due: int
    ping: tuple[int, int] | None
    """Sensor that was triggered in the last tick, and the length of its echo in µs; 0: none will come."""

    @classmethod
    def unpack(cls, data: bytes) -> Request:
        """From the 40 bytes. The echo that has ended by now is rover-sitl's; pins get their edges from `ping`."""
        now_us, left, right, _, battery_mv, _, stop, due, pinged, echo_us = REQUEST.unpack(data)
        ping = (pinged - 1, echo_us) if pinged else None
        return cls(now_us, (left, right), battery_mv, bool(stop), due, ping)


@dataclass(frozen=True)
class Reply:
    """The outputs at the end of the millisecond. Duties -1 to 1."""

    duty: tuple[float, float]
    powered: bool
    led: bool
    buzzer: bool
    trigger: int | None
    bytes_sent: int

    def pack(self) -> bytes:
        """The 16 bytes."""
        left, right = (max(-32768, min(32767, round(duty * 32768))) for duty in self.duty)
        flags = self.powered | self.led << 1 | self.buzzer << 2
        trigger = NO_SENSOR if self.trigger is None else self.trigger
        return REPLY.pack(left, right, flags, trigger, self.bytes_sent)
