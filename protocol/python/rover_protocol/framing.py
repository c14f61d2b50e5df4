"""Frames on the serial line: a zero byte, COBS(identifier u16 LE | sequence u8 | payload | CRC-16 LE), a zero byte.

A zero byte ends a frame and occurs nowhere else. The one in front ends what noise has put on the line before, so
that only a frame that noise has hit itself is lost. The sequence byte counts the frames of one direction; the
receiver counts its gaps.
"""

MAX_PAYLOAD = 8
OVERHEAD = 5
MAX_BODY = OVERHEAD + MAX_PAYLOAD
# A zero at both ends, and the first COBS code byte.
DELIMITERS = 3
MAX_FRAME = MAX_BODY + DELIMITERS


def crc16(data: bytes | bytearray, length: int) -> int:
    """CRC-16/CCITT-FALSE of the first `length` bytes.

    Polynomial 0x1021, start 0xFFFF, not reflected; b"123456789" gives 0x29B1.
    """
    crc = 0xFFFF
    for position in range(length):
        x = (crc >> 8) ^ data[position]
        x ^= x >> 4
        crc = ((crc << 8) ^ (x << 12) ^ (x << 5) ^ x) & 0xFFFF
    return crc


def encode_into(identifier: int, sequence: int, payload: bytes | bytearray, length: int, out: bytearray) -> int:
    """Write the frame with the first `length` bytes of `payload` to `out` (MAX_FRAME bytes); returns its length.

    Raises ValueError when `length` is beyond MAX_PAYLOAD.
    """
    if length > MAX_PAYLOAD:
        raise ValueError(f"a payload has at most {MAX_PAYLOAD} bytes, got {length}")
    body = length + OVERHEAD
    # The body stands behind the leading zero and the first code byte; COBS then only replaces its zeros.
    out[0] = 0
    out[1] = 0
    out[2] = identifier & 255
    out[3] = identifier >> 8 & 255
    out[4] = sequence & 255
    for position in range(length):
        out[5 + position] = payload[position]
    crc = 0xFFFF
    for position in range(2, length + 5):
        x = (crc >> 8) ^ out[position]
        x ^= x >> 4
        crc = ((crc << 8) ^ (x << 12) ^ (x << 5) ^ x) & 0xFFFF
    out[length + 5] = crc & 255
    out[length + 6] = crc >> 8
    code_at = 1
    for position in range(2, body + 2):
        if out[position] == 0:
            out[code_at] = position - code_at
            code_at = position
    out[code_at] = body + 2 - code_at
    out[body + 2] = 0
    return body + 3


def encode(identifier: int, sequence: int, payload: bytes | bytearray) -> bytes:
    """The frame as bytes, with a zero at both ends. Raises ValueError when the payload is too long."""
    out = bytearray(MAX_FRAME)
    return bytes(out[: encode_into(identifier, sequence, payload, len(payload), out)])


class Decoder:
    """Finds frames in a stream of bytes.

    Nothing at all between two zeros is no error, so a sender may begin with a zero to flush a line.

    Counters, which do not wrap here: `frames` good ones; `checksum_errors`; `malformed`: too short, too long,
    or ended in the middle of a COBS run; `lost`: gaps in the sequence byte, summed modulo 256 each.

    After push() returned True: `identifier`, `sequence`, `length`, and `payload` (a buffer that is used again; its
    first `length` bytes count).
    """

    def __init__(self) -> None:
        self.frames = 0
        self.checksum_errors = 0
        self.malformed = 0
        self.lost = 0
        self.identifier = 0
        self.sequence = 0
        self.length = 0
        self.payload = bytearray(MAX_PAYLOAD)
        self._body = bytearray(MAX_BODY)
        self._filled = 0
        self._run = 0
        self._started = False
        self._expected = -1

    def feed(self, data: bytes | bytearray) -> list[tuple[int, int, bytes]]:
        """List of (identifier, sequence, payload bytes) of the good frames that end within `data`."""
        frames = []
        for byte in data:
            if self.push(byte):
                frames.append((self.identifier, self.sequence, bytes(self.payload[: self.length])))
        return frames

    def push(self, byte: int) -> bool:
        """Take one byte; True when it was the zero that ends a good frame. Allocates nothing."""
        if byte:
            # A code byte n stands for a zero (but for the first) and n - 1 bytes behind it.
            if self._run:
                self._run -= 1
                self._append(byte)
            else:
                self._run = byte - 1
                if self._started:
                    self._append(0)
                self._started = True
            return False
        length = self._filled
        good = False
        if self._started:
            if self._run or length < OVERHEAD or length > MAX_BODY:
                self.malformed += 1
            else:
                good = self._check(length)
        self._started = False
        self._filled = 0
        self._run = 0
        return good

    def _append(self, byte: int) -> None:
        if self._filled < MAX_BODY:
            self._body[self._filled] = byte
        # One more than fits marks a frame that is too long.
        if self._filled <= MAX_BODY:
            self._filled += 1

    def _check(self, length: int) -> bool:
        body = self._body
        if crc16(body, length - 2) != body[length - 2] | body[length - 1] << 8:
            self.checksum_errors += 1
            return False
        self.identifier = body[0] | body[1] << 8
        self.sequence = body[2]
        self.length = length - OVERHEAD
        for position in range(self.length):
            self.payload[position] = body[3 + position]
        if self._expected >= 0:
            self.lost += (self.sequence - self._expected) & 255
        self._expected = (self.sequence + 1) & 255
        self.frames += 1
        return True
