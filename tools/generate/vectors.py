"""Write protocol/vectors/messages.json and streams.json, the golden vectors that every codec must agree with.

Made without any of the project's codecs: cantools packs the payloads, `binascii.crc_hqx` is the checksum, and COBS is
done here by splitting at zeros. Run `python -m tools.generate.vectors` after a message has been added to the DBC; the
existing vectors must not change unless the wire format does.
"""

from __future__ import annotations

import binascii
import json
from pathlib import Path

from cantools.database.can import Message, Signal

from tools.generate.schema import load_database

ROOT = Path(__file__).resolve().parents[2]
DBC = ROOT / "protocol" / "rover.dbc"
VECTORS = ROOT / "protocol" / "vectors"


def cobs(body: bytes) -> bytes:
    """Consistent overhead byte stuffing of less than 254 bytes: each run between zeros, preceded by its length + 1."""
    return b"".join(bytes([len(run) + 1]) + run for run in body.split(b"\0"))


def frame(identifier: int, sequence: int, payload: bytes) -> bytes:
    body = identifier.to_bytes(2, "little") + bytes([sequence]) + payload
    return b"\0" + cobs(body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "little")) + b"\0"


def extremes(signal: Signal) -> dict[str, int]:
    """Raw values that show a wrong width, sign or byte order."""
    bits = signal.length
    if signal.is_signed:
        return {
            "zero": 0,
            "lowest": -(1 << (bits - 1)),
            "highest": (1 << (bits - 1)) - 1,
            "minus one": -1,
        }
    return {"zero": 0, "lowest": 0, "highest": (1 << bits) - 1, "minus one": (1 << bits) - 1}


def counting(signal: Signal) -> int:
    """The value whose bytes on the wire are their own positions 1, 2, 3 ... in the payload."""
    first = signal.start // 8 + 1
    return int.from_bytes(bytes(range(first, first + signal.length // 8)), "little")


def message_vectors(message: Message, first_sequence: int) -> list[dict[str, object]]:
    cases: dict[str, dict[str, int]] = {"counting": {s.name: counting(s) for s in message.signals}}
    for case in ("zero", "lowest", "highest", "minus one"):
        values = {s.name: extremes(s)[case] for s in message.signals}
        if values not in cases.values():
            cases[case] = values
    vectors = []
    for number, (case, values) in enumerate(cases.items()):
        payload = message.encode(values, scaling=False)
        sequence = (first_sequence + number) % 256
        shown = {
            s.name: list(values[s.name].to_bytes(s.length // 8, "little")) if s.length > 32 else values[s.name]
            for s in message.signals
        }
        vectors.append(
            {
                "message": message.name,
                "case": case,
                "identifier": message.frame_id,
                "values": shown,
                "payload": payload.hex(),
                "sequence": sequence,
                "frame": frame(message.frame_id, sequence, payload).hex(),
            }
        )
    return vectors


def stream(name: str, data: bytes, frames: list[tuple[int, int, bytes]], *counters: int) -> dict[str, object]:
    checksum_errors, malformed, lost = counters
    return {
        "name": name,
        "input": data.hex(),
        "frames": [[identifier, sequence, payload.hex()] for identifier, sequence, payload in frames],
        "checksum_errors": checksum_errors,
        "malformed": malformed,
        "lost": lost,
    }


def stream_vectors() -> list[dict[str, object]]:
    """What a receiver makes of damaged streams. Counters in the order checksum errors, malformed, lost."""
    stop = (0x010, 0, b"\x07")
    alive = (0x020, 1, b"\x2a")
    empty = (0x7FF, 2, b"")
    zeros = (0x042, 3, bytes(6))
    wire = {message: frame(*message) for message in (stop, alive, empty, zeros)}
    damaged = bytearray(wire[alive])
    damaged[5] ^= 0x40
    run_too_long = bytes([9, 1, 2, 3, 4, 5, 0])
    nine = frame(0x060, 1, bytes(range(1, 10)))
    other = [(0x020, n, bytes([n])) for n in (254, 255, 0, 2)]
    return [
        stream("frames back to back", b"".join(wire.values()), list(wire), 0, 0, 0),
        stream("an idle line of zeros is no error", b"\0\0\0" + wire[stop] + b"\0\0", [stop], 0, 0, 0),
        stream("text before the first zero is one malformed frame", b"boot\0" + wire[stop], [stop], 0, 1, 0),
        stream("a receiver that joins in the middle of a frame", wire[stop][4:] + wire[alive], [alive], 0, 1, 0),
        stream("a frame cut off by the next one's leading zero", wire[stop][:5] + wire[alive], [alive], 0, 1, 0),
        stream("a flipped bit", wire[stop] + bytes(damaged) + wire[empty], [stop, empty], 1, 0, 1),
        stream("a run that reaches beyond the end", run_too_long + wire[stop], [stop], 0, 1, 0),
        stream("nine bytes of payload are too many, even with a right checksum", nine + wire[stop], [stop], 0, 1, 0),
        stream("noise between frames costs neither", wire[stop] + b"\x9b\x03" + wire[alive], [stop, alive], 0, 1, 0),
        stream("a hundred bytes without a zero", b"\x55" * 100 + b"\0" + wire[stop], [stop], 0, 1, 0),
        stream(
            "a frame whose zeros are lost makes one with its neighbour that is too long",
            frame(0x060, 0, bytes(8))[:-1] + wire[alive][1:],
            [],
            0,
            1,
            0,
        ),
        stream("the sequence wraps and then skips one", b"".join(frame(*m) for m in other), other, 0, 0, 1),
        stream("a duplicate is delivered, and counts as 255 lost", wire[stop] + wire[stop], [stop, stop], 0, 0, 255),
    ]


def main() -> None:
    database = load_database(DBC)
    vectors: list[dict[str, object]] = []
    for message in sorted(database.messages, key=lambda m: m.frame_id):
        vectors += message_vectors(message, len(vectors))
    for name, content in (("messages", vectors), ("streams", stream_vectors())):
        lines = ",\n".join("  " + json.dumps(vector) for vector in content)
        (VECTORS / f"{name}.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")
        print(f"{name}.json: {len(content)} vectors")


if __name__ == "__main__":
    main()
