"""One cycle of a mission on a real rover as bytes: what came over the wire, when, and how the link broke if it did.

f64 time | u16 leads | u16 chunks | u16 frames | u32 frames sent | u8 failed | u16 length of why
leads × f64 | chunks × (f64 time, u32 length, bytes) | frames × (f64 time, u16 identifier, u8 length, bytes) | why

Little-endian; failed: 0 no, 1 while sending, 2 while receiving. Times in seconds of the companion's clock.
"""

from __future__ import annotations

import struct

from rover.link.frames import Frame
from rover.link.intake import Cycle

HEAD = struct.Struct("<dHHHIBH")
LEAD = struct.Struct("<d")
CHUNK = struct.Struct("<dI")
FRAME = struct.Struct("<dHB")
FAILURES = ("", "send", "receive")


def pack_cycle(cycle: Cycle) -> bytes:
    """See the layout above."""
    why = cycle.why.encode()
    counts = len(cycle.leads), len(cycle.chunks), len(cycle.frames)
    head = HEAD.pack(cycle.time, *counts, cycle.sent, FAILURES.index(cycle.failed), len(why))
    leads = b"".join(LEAD.pack(lead) for lead in cycle.leads)
    chunks = b"".join(CHUNK.pack(at, len(data)) + data for at, data in cycle.chunks)
    frames = b"".join(FRAME.pack(f.time, f.identifier, len(f.payload)) + f.payload for f in cycle.frames)
    return head + leads + chunks + frames + why


def unpack_cycle(data: bytes) -> Cycle:
    """Raises ValueError for bytes that are no cycle."""
    try:
        time, leads, chunks, frames, sent, failed, why = HEAD.unpack_from(data)
        cycle = Cycle(time, sent=sent, failed=FAILURES[failed])
        at = HEAD.size
        for _ in range(leads):
            cycle.leads += LEAD.unpack_from(data, at)
            at += LEAD.size
        for _ in range(chunks):
            came, length = CHUNK.unpack_from(data, at)
            at += CHUNK.size + length
            cycle.chunks.append((came, data[at - length : at]))
        for _ in range(frames):
            came, identifier, length = FRAME.unpack_from(data, at)
            at += FRAME.size + length
            cycle.frames.append(Frame(came, identifier, data[at - length : at]))
    except (struct.error, IndexError) as error:
        raise ValueError(f"a cycle of {len(data)} bytes does not hold what its head says") from error
    if len(data) != at + why:
        raise ValueError(f"a cycle of {len(data)} bytes does not hold what its head says")
    cycle.why = data[at:].decode(errors="replace")
    return cycle
