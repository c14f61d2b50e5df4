"""The Python codec and cantools agree with the golden vectors byte for byte."""

from __future__ import annotations

from typing import Any

import pytest
from cantools.database.can import Database
from rover_protocol import framing, messages

from protocol.tests import golden

MESSAGES = golden.load("messages")
STREAMS = golden.load("streams")


@pytest.fixture(scope="module")
def database() -> Database:
    return golden.database()


def test_every_message_of_the_dbc_has_vectors(database: Database) -> None:
    assert {v["message"] for v in MESSAGES} == {m.name for m in database.messages}
    assert {m.name: m.frame_id for m in database.messages} == {n: m.ID for n, m in messages.BY_NAME.items()}


def test_payloads_pack_and_decode_as_in_the_vectors() -> None:
    for vector in MESSAGES:
        message = messages.BY_NAME[vector["message"]]
        payload = bytes.fromhex(vector["payload"])
        values = golden.values(vector)
        assert message.pack(**values) == payload, vector
        assert message.pack(*values.values()) == payload, vector
        assert message.unpack(payload) == tuple(values.values()), vector
        assert messages.decode(vector["identifier"], payload) == (message, values), vector


def test_cantools_packs_the_same_payloads(database: Database) -> None:
    for vector in MESSAGES:
        values = {
            name: int.from_bytes(value, "little") if isinstance(value, bytes) else value
            for name, value in golden.values(vector).items()
        }
        packed = database.encode_message(vector["identifier"], values, scaling=False)
        assert packed == bytes.fromhex(vector["payload"]), vector


def test_physical_values_are_those_of_cantools(database: Database) -> None:
    for vector in MESSAGES:
        if vector["message"] == "LogText":
            continue
        message = messages.BY_NAME[vector["message"]]
        payload = bytes.fromhex(vector["payload"])
        expected = database.decode_message(message.ID, payload, decode_choices=False)
        assert messages.physical(message, message.decode(payload)) == pytest.approx(expected), vector


def test_value_tables_are_those_of_the_dbc(database: Database) -> None:
    for message in database.messages:
        for signal in message.signals:
            table = {int(raw): str(name) for raw, name in (signal.choices or {}).items()}
            assert messages.VALUES.get(message.name, {}).get(signal.name, {}) == table
    assert messages.STATE_NAMES[messages.STATE_LATCHED] == "Latched"
    assert messages.VALUES["State"]["cause"][messages.STATE_CAUSE_DEAD_MAN] == "DeadMan"


def test_frames_encode_as_in_the_vectors() -> None:
    for vector in MESSAGES:
        payload = bytes.fromhex(vector["payload"])
        wire = framing.encode(vector["identifier"], vector["sequence"], payload)
        assert wire.hex() == vector["frame"], vector


@pytest.mark.parametrize("stream", STREAMS, ids=lambda s: s["name"])
def test_damaged_streams_yield_the_good_frames_and_counters(stream: dict[str, Any]) -> None:
    decoder = framing.Decoder()
    frames = [[i, s, p.hex()] for i, s, p in decoder.feed(bytes.fromhex(stream["input"]))]
    assert frames == stream["frames"]
    assert decoder.frames == len(frames)
    for counter in ("checksum_errors", "malformed", "lost"):
        assert getattr(decoder, counter) == stream[counter], counter


def test_a_frame_by_hand() -> None:
    """Stop with reason 7, first frame: identifier 0x010, so the body is 10 00 00 07 and its checksum 0xEF80.

    The two zeros become the code bytes 1 + 1 (one byte before the first zero) and 1 (none before the second).
    """
    body = bytes([0x10, 0x00, 0x00, 0x07])
    assert framing.crc16(body, 4) == 0xEF80
    assert framing.crc16(b"123456789", 9) == 0x29B1
    assert framing.encode(0x010, 0, b"\x07") == bytes([0, 2, 0x10, 1, 4, 0x07, 0x80, 0xEF, 0])
