"""A serial CAN adapter: slcan's lines on one side, as python-can and slcand speak them, a node of the bus on the other.

Frames that are taken are not answered: python-can would read the empty answer as "no message".
"""

from __future__ import annotations

from collections import deque

from rover_hil.emulator.can_bus import CanBus, Frame

END, REFUSED = 0x0D, b"\x07"
MAX_LINE_BYTES = 26
# Frames that the adapter keeps for the bus.
MAX_WAITING = 64
BIT_RATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)


class SlcanAdapter:
    """Takes the host's bytes, collects what it answers in `answers`."""

    def __init__(self, bus: CanBus) -> None:
        self._bus = bus
        self._line = bytearray()
        self._waiting: deque[Frame] = deque()
        self._open = False
        self._rate = 500_000.0
        self.answers = bytearray()
        bus.join(self)

    @property
    def bit_rate(self) -> float:
        """As set by the host; 0 while the channel is closed."""
        return self._rate if self._open else 0.0

    acknowledges = True

    def offered(self) -> Frame | None:
        """The frame that comes first."""
        return min(self._waiting, key=lambda frame: frame.arbitration, default=None)

    def sent(self, frame: Frame) -> None:
        """It is through."""
        self._waiting.remove(frame)

    def heard(self, frame: Frame) -> None:
        """Becomes a line for the host."""
        self.answers += self._text(frame)

    @staticmethod
    def _text(frame: Frame) -> bytes:
        kind = ("T" if frame.extended else "t", "R" if frame.extended else "r")[frame.remote]
        width = 8 if frame.extended else 3
        return f"{kind}{frame.identifier:0{width}X}{frame.length}{frame.data.hex().upper()}\r".encode()

    def failed(self, transmitting: bool, acknowledged: bool) -> None:
        """Tries again, like any controller; the adapter reports no errors."""

    def push(self, data: bytes) -> None:
        """Bytes of the host."""
        for byte in data:
            if byte != END:
                self._line.append(byte)
                continue
            line, self._line = bytes(self._line), bytearray()
            self.answers += self._execute(line) if len(line) <= MAX_LINE_BYTES else REFUSED

    def _execute(self, line: bytes) -> bytes:
        match line[:1]:
            case b"":
                return b""
            case b"O":
                self._open = True
                return b"\r"
            case b"C":
                self._open = False
                self._waiting.clear()
                return b"\r"
            case b"S" if line[1:].isdigit() and int(line[1:]) < len(BIT_RATES):
                self._rate = float(BIT_RATES[int(line[1:])])
                return b"\r"
            case b"Z" | b"M" | b"m":
                return b"\r"
            case b"V":
                return b"V0101\r"
            case b"N":
                return b"NROVR\r"
            case b"F":
                return b"F00\r"
            case b"t" | b"T" | b"r" | b"R":
                return self._transmit(line)
        return REFUSED

    def _transmit(self, line: bytes) -> bytes:
        frame = parse_frame(line)
        if frame is None or not self._open or len(self._waiting) >= MAX_WAITING:
            return REFUSED
        self._waiting.append(frame)
        self._bus.request()
        return b""


def parse_frame(line: bytes) -> Frame | None:
    """The frame of a line without its end; None when it is not one."""
    extended, remote = line[:1] in b"TR", line[:1] in b"rR"
    width = 8 if extended else 3
    try:
        identifier, length = int(line[1 : 1 + width], 16), int(line[1 + width : 2 + width])
        data = bytes.fromhex(line[2 + width :].decode("ascii"))
    except ValueError:
        return None
    if identifier >= (1 << 29 if extended else 1 << 11) or length > 8 or len(data) != (0 if remote else length):
        return None
    return Frame(identifier, data, extended, remote, length)
