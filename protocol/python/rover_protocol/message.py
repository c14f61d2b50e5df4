"""One message: where its fields lie, and how they are put in and taken out.

Fields are little-endian integers of 1 to 4 bytes; a longer one is text and is held as bytes.
"""


class Message:
    """Layout of a message. `fields` are tuples (name, first byte, bytes, signed)."""

    def __init__(self, name: str, identifier: int, length: int, fields: tuple[tuple[str, int, int, bool], ...]) -> None:
        self.name = name
        self.ID = identifier
        self.LENGTH = length
        self.FIELDS = tuple([field[0] for field in fields])
        self._layout = fields

    def __repr__(self) -> str:
        return f"<Message {self.name} 0x{self.ID:03x}>"

    def pack(self, *values: int | bytes, **named: int | bytes) -> bytes:
        """Payload from raw values, in the order of FIELDS or by name; what is not given is 0.

        Raises ValueError for a field that the message does not have or a value that does not fit.
        """
        given = list(values)
        if len(given) > len(self.FIELDS):
            raise ValueError(f"{self.name} has {len(self.FIELDS)} fields, got {len(given)} values")
        for name, _, size, _ in self._layout[len(given) :]:
            given.append(named.pop(name, b"" if size > 4 else 0))
        for name in named:
            problem = "given twice" if name in self.FIELDS else "no such field"
            raise ValueError(f"{self.name}.{name}: {problem}")
        payload = bytearray(self.LENGTH)
        self.pack_into(payload, given)
        return bytes(payload)

    def pack_into(self, buffer: bytearray, values: list[int | bytes] | tuple[int | bytes, ...]) -> int:
        """Write raw `values`, one for each field, to the first LENGTH bytes of `buffer`; returns LENGTH."""
        position = -1
        for name, start, size, signed in self._layout:
            position += 1
            value = values[position]
            if size > 4:
                if isinstance(value, int):
                    raise ValueError(f"{self.name}.{name}: bytes are expected, got {value}")
                self._pack_text(buffer, name, start, size, value)
                continue
            if isinstance(value, bytes):
                raise ValueError(f"{self.name}.{name}: a number is expected, got {value!r}")
            low = -(1 << (8 * size - 1)) if signed else 0
            if not low <= value < low + (1 << (8 * size)):
                raise ValueError(f"{self.name}.{name}: {value} does not fit {8 * size} bits")
            for offset in range(size):
                buffer[start + offset] = value & 255
                value >>= 8
        return self.LENGTH

    def _pack_text(self, buffer: bytearray, name: str, start: int, size: int, value: bytes) -> None:
        if len(value) > size:
            raise ValueError(f"{self.name}.{name}: {value!r} is longer than {size} bytes")
        for offset in range(size):
            buffer[start + offset] = value[offset] if offset < len(value) else 0

    def unpack(self, payload: bytes | bytearray) -> tuple[int | bytes, ...]:
        """Tuple of raw values, in the order of FIELDS. Raises ValueError when `payload` has another length."""
        values: list[int | bytes] = [0] * len(self.FIELDS)
        if len(payload) != self.LENGTH:
            raise ValueError(f"{self.name} has {self.LENGTH} bytes, got {len(payload)}")
        self.unpack_into(payload, values)
        return tuple(values)

    def unpack_into(self, payload: bytes | bytearray, values: list[int | bytes]) -> int:
        """Set values[i] to the raw value of the i-th field; returns their number.

        `payload` holds at least LENGTH bytes. Allocates nothing but for texts and, on 32-bit MicroPython, integers
        beyond 30 bits.
        """
        position = 0
        for _, start, size, signed in self._layout:
            if size > 4:
                values[position] = bytes(payload[start : start + size])
            else:
                # The top byte first: its sign is that of the whole.
                value = payload[start + size - 1]
                if signed and value > 127:
                    value -= 256
                for offset in range(start + size - 2, start - 1, -1):
                    value = (value << 8) | payload[offset]
                values[position] = value
            position += 1
        return position

    def decode(self, payload: bytes | bytearray) -> dict[str, int | bytes]:
        """Dict of field name to raw value. Raises ValueError when `payload` has another length."""
        values = self.unpack(payload)
        return {name: values[position] for position, name in enumerate(self.FIELDS)}
