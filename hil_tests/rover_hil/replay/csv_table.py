"""CSV files that a person wrote: named columns, numbers, and errors that name file, line and column."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rover.errors import BadInput


@dataclass(frozen=True)
class Row:
    """One line, by the names of its columns."""

    file: Path
    line: int
    values: dict[str, str]

    def text(self, column: str) -> str:
        """What stands there; "" where nothing does or the column is left out."""
        return (self.values.get(column) or "").strip()

    def number(self, column: str) -> float:
        """Raises BadInput unless it is a finite number."""
        try:
            value = float(self.text(column))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.fail(column, "a number is expected")
        return value

    def whole(self, column: str) -> int:
        """Raises BadInput unless it is a whole number."""
        value = self.number(column)
        if value != int(value):
            raise self.fail(column, "a whole number is expected")
        return int(value)

    def fail(self, column: str, what: str) -> BadInput:
        """The error that names the place."""
        return BadInput(f"{self.file}:{self.line}: {column}: {what}, not {self.text(column)!r}")


def read_csv(file: Path, needed: tuple[str, ...], optional: tuple[str, ...] = ()) -> Iterator[Row]:
    """Rows in order, whose `time_s` must grow. Raises BadInput for a missing file or column, and for bad rows."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise BadInput(f"{file}: no such file; columns {', '.join(needed)} are expected in it") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{file}: cannot be read as text: {error}") from error
    reader = csv.DictReader(text.splitlines())
    columns = [name.strip() for name in reader.fieldnames or []]
    missing = [name for name in needed if name not in columns]
    if missing:
        raise BadInput(
            f"{file}:1: no column {', '.join(missing)}; the first line names the columns: {','.join(needed)}"
        )
    strange = [name for name in columns if name not in (*needed, *optional)]
    if strange:
        raise BadInput(
            f"{file}:1: column {', '.join(strange)} is not known; known are {', '.join((*needed, *optional))}"
        )
    before = -math.inf
    for values in reader:
        row = Row(file, reader.line_num, {key.strip(): value or "" for key, value in values.items() if key is not None})
        time = row.number("time_s")
        if time < before:
            raise row.fail("time_s", f"times must not go back, the line before has {before:g}")
        before = time
        yield row
