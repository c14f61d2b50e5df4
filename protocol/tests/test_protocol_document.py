"""docs/reference/protocol.md agrees with the DBC, the vectors, the codec and the firmware's own tables."""

from __future__ import annotations

import re

import pytest
from cantools.database.can import Database
from rover_protocol import framing, messages

from protocol.tests import golden

REPOSITORY = golden.PROTOCOL.parent
DOCUMENT = (REPOSITORY / "docs/reference/protocol.md").read_text(encoding="utf-8")
CORE = REPOSITORY / "firmware/core/src"


def found(pattern: str, text: str) -> re.Match[str]:
    """Where the pattern stands first."""
    match = re.search(pattern, text, re.MULTILINE)
    assert match is not None, pattern
    return match


def rows(heading: str) -> list[list[str]]:
    """Cells of the first table below the heading, without its two first lines."""
    section = DOCUMENT[DOCUMENT.index(f"\n{heading}\n") :]
    table = found(r"(?:^\|.*\n)+", section)[0]
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table.splitlines()[2:]]


@pytest.fixture(scope="module")
def database() -> Database:
    return golden.database()


def test_every_message_is_listed_as_the_dbc_has_it(database: Database) -> None:
    listed = {int(row[0]): row for row in rows("## Messages")}
    assert sorted(listed) == sorted(message.frame_id for message in database.messages)
    for message in database.messages:
        number, code, name, sender, length, fields = listed[message.frame_id]
        assert (int(code, 16), name, sender) == (int(number), message.name, message.senders[0].lower())
        assert int(length) == message.length
        described = []
        for signal in sorted(message.signals, key=lambda s: s.start):
            kind = f"{'i' if signal.is_signed else 'u'}{signal.length}" if signal.length < 56 else "7 bytes"
            scaled = signal.scale != 1 or signal.unit
            scale = f" × {signal.scale:g} {signal.unit or ''}".rstrip() if scaled else ""
            described.append(f"`{signal.name}` {kind}{scale}")
        assert fields == ", ".join(described), message.name


def test_the_schema_hash_is_the_present_one() -> None:
    assert f"0x{messages.SCHEMA_HASH:08x}" in DOCUMENT


def test_the_frame_by_hand_is_in_the_vectors() -> None:
    example = found(r"^frame +([0-9a-f ]+)$", DOCUMENT)[1]
    vector = next(v for v in golden.load("messages") if v["frame"] == example.replace(" ", ""))
    assert (vector["message"], vector["sequence"], vector["values"]) == ("Arm", 7, {"token": 0, "session": 0})
    body = bytes.fromhex(found(r"^body +([0-9a-f ]+)$", DOCUMENT)[1])
    assert framing.crc16(body, len(body) - 2) == int.from_bytes(body[-2:], "little") == 0x32CC


def test_the_session_is_what_the_codec_sends() -> None:
    for sequence, (wire, described) in enumerate(rows("## A session, byte by byte")):
        name, fields = described.split(" ", 1)
        values = {key: int(value) for key, value in (field.split(" ") for field in fields.split(", "))}
        message = messages.BY_NAME[name]
        expected = framing.encode(message.ID, sequence, message.pack(**values))
        assert bytes.fromhex(wire.strip("`")) == expected, described


def test_telemetry_periods_are_those_of_the_firmware() -> None:
    source = (CORE / "telemetry.rs").read_text(encoding="utf-8")
    periods = {name: f"{period} ms" for name, period in re.findall(r"entry\(m::(\w+)::ID, (\d+), \d+\)", source)}
    assert len(periods) == 12
    assert {row[0]: row[1] for row in rows("## Telemetry")} == {**periods, "Sonar": ""}


@pytest.mark.parametrize(
    ("heading", "message", "signal"),
    [("## Faults", "Fault", "code"), ("## State", "State", "state")],
)
def test_numbers_and_names_are_the_value_tables_of_the_dbc(heading: str, message: str, signal: str) -> None:
    names = {number: name for number, name in messages.VALUES[message][signal].items() if name != "None"}
    assert {int(row[0]): row[1] for row in rows(heading)} == names


def test_causes_are_the_value_table_of_the_dbc() -> None:
    section = DOCUMENT[DOCUMENT.index("| cause | name |") : DOCUMENT.index("`flags`: bit 0")]
    causes = {int(number): name for number, name in re.findall(r"^\| (\d+) \| (\w+) \|", section, re.MULTILINE)}
    assert causes == messages.VALUES["State"]["cause"]


def test_reasons_of_refusal_are_numbered_as_in_the_firmware() -> None:
    source = (CORE / "motion.rs").read_text(encoding="utf-8")
    body = found(r"(?s)pub enum Refusal \{(.*?)\n\}", source)[1]
    names = re.findall(r"^    (\w+),$", body, re.MULTILINE)
    assert names == ["QueueFull", "TooShort", "NotContinuous", "StartPassed", "BeyondLimits", "NotAtRest"]
    assert [int(row[0]) for row in rows("### Refusal")] == list(range(len(names)))
