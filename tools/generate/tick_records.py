"""The records of protocol/rig_tick.toml in the plain form that the generators need."""

from __future__ import annotations

import struct
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

STRUCT_CODES = {"u8": "B", "u16": "H", "i16": "h", "u32": "I", "i32": "i", "u64": "Q", "i64": "q"}


@dataclass(frozen=True)
class Constant:
    name: str
    type: str
    value: int
    comment: str


@dataclass(frozen=True)
class TickField:
    """One integer, or `size` bytes of padding when `name` is empty. `start` and `size` count bytes; `default` is what
    Python assumes for a value that is not given."""

    name: str
    type: str
    start: int
    size: int
    default: int
    comment: str


@dataclass(frozen=True)
class TickRecord:
    """Fields in order; together they are `size` bytes long, and `format` is how `struct` calls them."""

    name: str
    comment: str
    size: int
    format: str
    fields: tuple[TickField, ...]

    @property
    def named(self) -> tuple[TickField, ...]:
        """Without the padding."""
        return tuple(field for field in self.fields if field.name)


@dataclass(frozen=True)
class TickRecords:
    constants: tuple[Constant, ...]
    records: tuple[TickRecord, ...]


def load(path: Path) -> TickRecords:
    """Read the description. Raises ValueError for a type that is not known or a key that is missing."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    try:
        return TickRecords(
            tuple(Constant(name, entry["type"], entry["value"], entry["comment"])
                  for name, entry in table["constants"].items()),
            tuple(_record(name, entry) for name, entry in table["records"].items()),
        )  # fmt: skip
    except KeyError as error:
        raise ValueError(f"no such key or type: {error}") from error


def _record(name: str, entry: dict[str, Any]) -> TickRecord:
    fields: list[TickField] = []
    layout = "<"
    for part in entry["fields"]:
        padding = part.get("padding", 0)
        code = f"{padding}x" if padding else STRUCT_CODES[part["type"]]
        size = struct.calcsize("<" + code)
        start = struct.calcsize(layout)
        layout += code
        fields.append(
            TickField(
                part.get("name", ""),
                part.get("type", ""),
                start,
                size,
                part.get("default", 0),
                part.get("comment", ""),
            )
        )
    return TickRecord(name, entry["comment"], struct.calcsize(layout), layout, tuple(fields))
