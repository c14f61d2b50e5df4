"""The emulated board keeps in its flash what was saved, through a restart."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from rover.errors import PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover_hil.firmware_process import FirmwareProcess, emulator_command
from rover_protocol import framing, messages
from rover_protocol.rig_tick import TickReply, TickRequest

pytestmark = pytest.mark.rig("emulator")

DEAD_MAN, OTHER = 1, 417
RESTART = 0x5242_4F54


class Board:
    """The emulated board as a process, on a bench of its own."""

    def __init__(self) -> None:
        self._process = FirmwareProcess(emulator_command(), DEFAULT_BAUD)
        self._decoder = framing.Decoder()
        self._now_us = self._sent = self._received = 0
        self.heard: list[tuple[str, dict[str, Any]]] = []

    def tell(self, name: str, **values: int) -> None:
        message = messages.BY_NAME[name]
        data = framing.encode(message.ID, 0, message.pack(**values))
        self._sent += len(data)
        self._process.send(data)

    def run(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self._now_us += 1000
            request = TickRequest(now_us=self._now_us, battery_mv=7400, host_bytes_due=self._sent)
            self._process.stdin.write(request.pack())
            self._process.stdin.flush()
            total = TickReply.unpack(self._process.stdout.read(TickReply.SIZE)).bytes_sent
            data = self._process.receive(total - self._received)
            self._received = total
            for identifier, _, payload in self._decoder.feed(data):
                message, fields = messages.decode(identifier, payload)
                self.heard.append((message.name, fields))

    def parameter(self) -> int:
        self.heard.clear()
        self.tell("ParameterGet", identifier=DEAD_MAN)
        self.run(20)
        value: int = next(fields["value"] for name, fields in self.heard if name == "ParameterValue")
        return value

    def close(self) -> None:
        self._process.close()


@pytest.fixture
def board() -> Iterator[Board]:
    try:
        made = Board()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    yield made
    made.close()


def _restart(board: Board) -> None:
    board.tell("Hello", schema_hash=0, session=1)  # whoever asks for a restart has said hello, of whatever schema
    board.tell("Reboot", magic=RESTART, session=1)
    board.run(300)


def test_a_saved_parameter_survives_a_restart_and_one_that_was_only_set_does_not(board: Board) -> None:
    board.run(100)
    before = board.parameter()
    board.tell("ParameterSet", identifier=DEAD_MAN, value=OTHER)
    board.run(20)
    assert board.parameter() == OTHER
    _restart(board)
    assert board.parameter() == before
    board.tell("ParameterSet", identifier=DEAD_MAN, value=OTHER)
    board.tell("ParameterCommand", command=messages.PARAMETER_COMMAND_SAVE)
    board.run(200)
    _restart(board)
    assert board.parameter() == OTHER
