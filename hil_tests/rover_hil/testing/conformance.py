"""The same inputs to the core on the desktop and to the flashed ELF, compared tick by tick.

Both are processes that speak the same ticks. A recording's requests go to each of them unchanged, with the bytes of the
host that belong to them; what they answer in every tick is compared, and so is every message that they send, with
the tick in which it came.

What a message may hold that differs: who one is, and when the interrupt was served that a clock's request raised.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rover.link.baud import DEFAULT_BAUD
from rover_protocol import framing, messages
from rover_protocol.rig_tick import TickReply

from rover_hil.firmware_process import FirmwareProcess
from rover_hil.tick_recorder import Tick

# Fields that tell one from the other.
IDENTITY = {"HelloReply": {"board"}, "HelloBuild": {"git_hash"}}
CLOCK_FIELDS = ("receive_time", "turnaround")
# Between the ends of a request's last byte and the driver's look at the clock.
CLOCK_TOLERANCE_US = 3
# Fields that may differ by one where two edges of the board meet: an echo that ends while the UART is served counts a
# millimetre more, and a status written in the millisecond in which a segment comes counts it or not.
OFF_BY_ONE = {"Sonar": ("range",), "MotionStatus": ("next_index", "free_slots", "queued")}


@dataclass(frozen=True)
class Outputs:
    """What a tick leads to. Duties in Q15, as the bridge sees them; `sent`: bytes so far."""

    duty: tuple[int, int]
    flags: int
    trigger: int
    sent: int


@dataclass(frozen=True)
class Sent:
    """A message in the tick in which its last byte came."""

    tick: int
    name: str
    fields: dict[str, int | bytes]


@dataclass(frozen=True)
class Compared:
    """One tick on both."""

    tick: int
    time_us: int
    sitl: Outputs
    board: Outputs


class _Firmware:
    """One of the two, with what it has said so far."""

    def __init__(self, command: list[str], baud: int) -> None:
        self._process = FirmwareProcess(command, baud)
        self._name = command[0]
        self._decoder = framing.Decoder()
        self._total = 0
        self.messages: list[Sent] = []

    def ask(self, tick: Tick) -> None:
        self._process.send(tick.host)
        self._process.stdin.write(tick.raw)
        self._process.stdin.flush()

    def answer(self, number: int) -> Outputs:
        """Raises ConnectionError when there is none."""
        data = self._process.stdout.read(TickReply.SIZE)
        if len(data) < TickReply.SIZE:
            raise ConnectionError(f"{self._name} has ended at tick {number}")
        reply = TickReply.unpack(data)
        said = self._process.receive(reply.bytes_sent - self._total)
        self._total = reply.bytes_sent
        for identifier, _, payload in self._decoder.feed(said):
            message, fields = messages.decode(identifier, payload)
            self.messages.append(Sent(number, message.name, fields))
        return Outputs((reply.duty_left, reply.duty_right), reply.flags, reply.sonar_trigger, reply.bytes_sent)

    @property
    def faulty_frames(self) -> int:
        """Frames that did not come whole."""
        return self._decoder.checksum_errors + self._decoder.malformed + self._decoder.lost

    def close(self) -> None:
        self._process.close()


class Conformance:
    """Compares what two firmwares make of a recording; afterwards `messages` holds what each has said: core, ELF."""

    def __init__(self, board: list[str], sitl: list[str], baud: int = DEFAULT_BAUD) -> None:
        """Command lines of the emulated board and of rover-sitl."""
        self._commands, self._baud = (sitl, board), baud
        self.messages: tuple[list[Sent], list[Sent]] = ([], [])
        self.faulty_frames = 0

    def run(self, ticks: Iterable[Tick]) -> Iterator[Compared]:
        """One comparison for each tick. Raises ConnectionError when one of them ends before the ticks do."""
        sitl, board = (_Firmware(command, self._baud) for command in self._commands)
        self.messages = (sitl.messages, board.messages)
        try:
            for number, tick in enumerate(ticks):
                board.ask(tick)
                sitl.ask(tick)
                mine = sitl.answer(number)
                yield Compared(number, tick.request.now_us, mine, board.answer(number))
            self.faulty_frames = sitl.faulty_frames + board.faulty_frames
        finally:
            sitl.close()
            board.close()


def differing_messages(one: Sequence[Sent], other: Sequence[Sent]) -> Iterator[tuple[Sent, Sent]]:
    """Messages that differ in name, tick or content, apart from who sends them and the order of two interrupts."""
    for mine, yours in zip(one, other, strict=True):
        if (mine.tick, mine.name) != (yours.tick, yours.name) or not _alike(mine, yours):
            yield mine, yours


def _alike(mine: Sent, yours: Sent) -> bool:
    ignored = IDENTITY.get(mine.name, set())
    for field, value in mine.fields.items():
        other = yours.fields[field]
        if field in ignored or value == other:
            continue
        apart = abs(int(value) - int(other))
        late = mine.name == "ClockReply" and field in CLOCK_FIELDS and apart <= CLOCK_TOLERANCE_US
        meets = field in OFF_BY_ONE.get(mine.name, ()) and apart <= 1
        if not (late or meets):
            return False
    return True
