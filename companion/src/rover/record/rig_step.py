"""One step of a simulated rig as bytes: everything that entered the firmware in it, and everything that left.

u64 now_us | u32 ticks | u32 bytes to the firmware | u32 from it | ticks × (TickRequest, TickReply) | bytes | bytes

Little-endian. Request and reply are described in protocol/rig_tick.toml: encoder counts, echo, voltage, emergency stop
and due host bytes go in; duties, lamp, buzzer, trigger and the count of sent bytes come out.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from rover_protocol.rig_tick import TickReply, TickRequest

HEAD = struct.Struct("<QIII")
TICK_SIZE = TickRequest.SIZE + TickReply.SIZE
TICK_US = 1000


@dataclass(frozen=True)
class RigStep:
    """The milliseconds up to `now_us`: requests and replies of each, and the wire's bytes in both directions.

    `to_firmware` was handed over at the beginning of the step; each request says how much of it is due.
    """

    now_us: int
    requests: tuple[bytes, ...]
    replies: tuple[bytes, ...]
    to_firmware: bytes
    from_firmware: bytes

    @property
    def start_us(self) -> int:
        """When it began."""
        return self.now_us - TICK_US * len(self.requests)

    def marks(self) -> list[tuple[int, int]]:
        """(time in µs, bytes that the firmware had sent in all) at the end of each tick."""
        sent = [TickReply.unpack(reply).bytes_sent for reply in self.replies]
        return [(self.start_us + TICK_US * (index + 1), total) for index, total in enumerate(sent)]


def pack_step(now_us: int, ticks: bytes, to_firmware: bytes, from_firmware: bytes) -> bytes:
    """`ticks`: request and reply of each millisecond, one after the other."""
    head = HEAD.pack(now_us, len(ticks) // TICK_SIZE, len(to_firmware), len(from_firmware))
    return head + ticks + to_firmware + from_firmware


def unpack_step(data: bytes) -> RigStep:
    """Raises ValueError for bytes that are no step."""
    if len(data) < HEAD.size:
        raise ValueError(f"a step of {len(data)} bytes is too short")
    now_us, count, to_firmware, from_firmware = HEAD.unpack_from(data)
    first = HEAD.size + TICK_SIZE * count
    second = first + to_firmware
    if len(data) != second + from_firmware:
        raise ValueError(f"a step of {len(data)} bytes does not hold what its head says")
    starts = range(HEAD.size, first, TICK_SIZE)
    return RigStep(
        now_us,
        tuple(data[at : at + TickRequest.SIZE] for at in starts),
        tuple(data[at + TickRequest.SIZE : at + TICK_SIZE] for at in starts),
        data[first:second],
        data[second:],
    )
