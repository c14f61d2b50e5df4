"""What a companion needs to replace any firmware stays as it is for ever; docs/reference/update.md says why."""

from __future__ import annotations

import pytest
from rover_protocol import framing, messages

from protocol.tests import golden
from tools.generate.schema import load_database

# Identifier, length, and (name, first bit, bits) of each field. Nothing here may change.
FROZEN = {
    "Hello": (256, 6, (("schema_hash", 0, 32), ("session", 32, 16))),
    "HelloReply": (
        257,
        8,
        (
            ("schema_hash", 0, 32),
            ("version_major", 32, 8),
            ("version_minor", 40, 8),
            ("version_patch", 48, 8),
            ("board", 56, 8),
        ),
    ),
    "HelloBuild": (258, 8, (("git_hash", 0, 32), ("reset_cause", 32, 8), ("accepted", 40, 8), ("session", 48, 16))),
    "HelloBusy": (259, 5, (("session", 0, 16), ("holder", 16, 16), ("wire", 32, 8))),
    "Reboot": (2032, 6, (("magic", 0, 32), ("session", 32, 16))),
}


# Reboot into the boot loader, session 4711, as the first frame of a sender.
FRAME = "00 03 f0 07 09 54 4f 4f 42 67 12 d6 a0 00"


@pytest.mark.parametrize("name", FROZEN)
def test_a_frozen_message_is_as_it_was(name: str) -> None:
    message = load_database(golden.PROTOCOL / "rover.dbc").get_message_by_name(name)
    fields = tuple((signal.name, signal.start, signal.length) for signal in message.signals)
    assert (message.frame_id, message.length, fields) == FROZEN[name]


def test_the_frame_of_a_restart_into_the_boot_loader_is_as_it_was() -> None:
    payload = messages.Reboot.pack(magic=0x424F_4F54, session=4711)
    assert framing.encode(messages.Reboot.ID, 0, payload).hex(" ") == FRAME
