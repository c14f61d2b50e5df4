"""A board between a serial line and a bus, as tests of the emulated board lay it out."""

from __future__ import annotations

from functools import partial

import pytest
from rover.link.baud import DEFAULT_BAUD
from rover_hil.firmware_process import find_elf
from rover_protocol import framing, messages

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator.board import TICK_CYCLES, Board
from rover_hil.emulator.can_wire import fit_controller
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.slcan import SlcanAdapter
from rover_hil.emulator.tick_pipe import Request

DRIVER = 1
BYTE_CYCLES = 10 * CYCLES_PER_US * 1_000_000 / DEFAULT_BAUD


class Desk:
    """A board between a serial line and a bus; two companions' frames by message name."""

    def __init__(self) -> None:
        self.chip = Chip()
        self.board = Board(self.chip)
        self.bus = SlcanAdapter(fit_controller(self.chip))
        self.bus.push(b"S6\rO\r")
        self.bus.answers.clear()
        self.chip.load(flash_segments(find_elf()))
        self.chip.uarts[0].on_sent = self._byte
        self._decoder = framing.Decoder()
        self._now = self._counter = self._sequence = 0
        self._line_free = 0.0
        self.log = b""
        self.frames: list[tuple[str, dict[str, int]]] = []
        self.line_heard: dict[str, dict[str, int]] = {}
        self.bus_heard: dict[str, dict[str, int]] = {}

    def run(self, milliseconds: int, alive: bool = False) -> None:
        for passed in range(milliseconds):
            if alive and passed % 100 == 0:
                self._counter = (self._counter + 1) & 255
                self.say("KeepAlive", counter=self._counter)
            trigger = self.board.take_trigger()
            ping = None if trigger is None else (trigger, 5800)
            self.board.apply(self.request(ping), self._now)
            self._now += TICK_CYCLES
            self.chip.run_until(self._now)
            self._take_bus()

    @property
    def milliseconds(self) -> int:
        """Since the board was switched on."""
        return self._now // TICK_CYCLES

    def request(self, ping: tuple[int, int] | None) -> Request:
        """The world of the next millisecond."""
        return Request(self._now // CYCLES_PER_US, (0, 0), 7400, False, 0, ping)

    def say(self, name: str, **fields: int) -> None:
        """On the serial line."""
        message = messages.BY_NAME[name]
        due = max(self._now, self._line_free)
        for byte in framing.encode(message.ID, self._sequence, message.pack(**fields)):
            due += BYTE_CYCLES
            alarm = self.chip.virtual_clock.create_alarm(partial(self.chip.uarts[0].receive, byte, DEFAULT_BAUD))
            alarm.schedule_at(round(due))
        self._line_free = due
        self._sequence = (self._sequence + 1) & 255

    def put(self, name: str, **fields: int) -> None:
        """On the bus."""
        message = messages.BY_NAME[name]
        data = message.pack(**fields)
        self.bus.push(f"t{message.ID:03x}{len(data)}{data.hex()}\r".encode())

    def arm_over_the_line(self) -> None:
        self.run(100)
        self.say("Hello", schema_hash=messages.SCHEMA_HASH, session=DRIVER)
        self.run(10)
        self.say("Arm", token=1, session=DRIVER)
        self.run(200, alive=True)
        assert self.line_heard["State"]["state"] == messages.STATE_ARMED

    def _byte(self, byte: int) -> None:
        if self._decoder.push(byte):
            payload = bytes(self._decoder.payload[: self._decoder.length])
            if self._decoder.identifier == messages.LogText.ID:
                self.log += payload[1:].rstrip(b"\0")
            self._note(self.line_heard, self._decoder.identifier, payload)
            message, fields = messages.decode(self._decoder.identifier, payload)
            self.frames.append((message.name, {k: v for k, v in fields.items() if isinstance(v, int)}))

    def _take_bus(self) -> None:
        text, _, rest = bytes(self.bus.answers).rpartition(b"\r")
        self.bus.answers[:] = rest
        for line in text.split(b"\r"):
            if line.startswith(b"t"):
                self._note(self.bus_heard, int(line[1:4], 16), bytes.fromhex(line[5:].decode()))

    @staticmethod
    def _note(heard: dict[str, dict[str, int]], identifier: int, payload: bytes) -> None:
        message, fields = messages.decode(identifier, payload)
        heard[message.name] = {name: value for name, value in fields.items() if isinstance(value, int)}
