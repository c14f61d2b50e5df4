"""The messages of a DBC file in the plain form that the generators need, and the hash that both ends compare."""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cantools
from cantools.database.can import Database

BIT_WIDTHS = (8, 16, 24, 32, 56)


@dataclass(frozen=True)
class Field:
    """One signal. `start` and `size` count bytes; `values` is its value table, (raw, name) in raw order."""

    name: str
    start: int
    size: int
    signed: bool
    factor: float
    unit: str
    comment: str
    values: tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Layout:
    """One message; its fields lie one after the other and fill `length` bytes."""

    name: str
    identifier: int
    length: int
    sender: str
    comment: str
    fields: tuple[Field, ...]


@dataclass(frozen=True)
class Schema:
    messages: tuple[Layout, ...]
    hash: int


def snake(name: str) -> str:
    """`SegmentTravel` -> `segment_travel`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def table_name(message: Layout, field: Field) -> str:
    """Name of a value table, `state_cause`; not doubled where the message is named after it: `state`."""
    prefix = snake(message.name)
    return prefix if prefix.endswith(field.name) else f"{prefix}_{field.name}"


def normalised(messages: tuple[Layout, ...]) -> str:
    """The text that the schema hash is taken of: one line a message, in order of identifiers."""
    lines = []
    for message in messages:
        signals = ";".join(
            f"{f.name}:{8 * f.start}:{8 * f.size}:{'-' if f.signed else '+'}:{f.factor:.12g}" for f in message.fields
        )
        lines.append(f"{message.identifier} {message.name} {message.length} {signals}")
    return "\n".join(lines)


def load_database(path: Path) -> Database:
    """Read a DBC. Raises ValueError for a database of another kind, cantools.Error for what is no DBC."""
    database = cantools.database.load_file(path, strict=True)
    if not isinstance(database, Database):
        raise ValueError(f"{path}: a CAN database is expected")
    return database


def load(path: Path) -> Schema:
    """Read a DBC. Raises ValueError when a signal is not byte-aligned little-endian or leaves a gap."""
    database = load_database(path)
    messages = []
    for message in sorted(database.messages, key=lambda m: m.frame_id):
        if message.is_extended_frame or message.length > 8:
            raise ValueError(f"{message.name}: must be a standard frame of at most 8 bytes")
        fields = []
        end = 0
        for signal in sorted(message.signals, key=lambda s: s.start):
            where = f"{message.name}.{signal.name}"
            if signal.byte_order != "little_endian" or signal.length not in BIT_WIDTHS or signal.offset != 0:
                raise ValueError(f"{where}: must be little-endian, {BIT_WIDTHS} bits wide and without offset")
            if signal.start != 8 * end:
                raise ValueError(f"{where}: starts at bit {signal.start}, expected {8 * end}")
            table: Mapping[int, object] = signal.choices or {}
            fields.append(
                Field(
                    name=signal.name,
                    start=end,
                    size=signal.length // 8,
                    signed=signal.is_signed,
                    factor=float(signal.scale),
                    unit=signal.unit or "",
                    comment=signal.comment or "",
                    values=tuple(sorted((int(raw), str(name)) for raw, name in table.items())),
                )
            )
            end += signal.length // 8
        if end != message.length:
            raise ValueError(f"{message.name}: signals fill {end} bytes of {message.length}")
        messages.append(
            Layout(
                name=message.name,
                identifier=message.frame_id,
                length=message.length,
                sender=message.senders[0],
                comment=message.comment or "",
                fields=tuple(fields),
            )
        )
    layouts = tuple(messages)
    return Schema(messages=layouts, hash=zlib.crc32(normalised(layouts).encode()))
