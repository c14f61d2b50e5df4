"""Strict reading of one TOML table: every key is asked for once, and what nobody asked for is an error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rover.errors import BadInput

_MISSING = object()


class Table:
    """One table of a file. Every method raises BadInput with file, key and what is wrong."""

    def __init__(self, path: Path, name: str, values: Any) -> None:
        self.path = path
        self.name = name
        if not isinstance(values, dict):
            raise BadInput(f"{path}: {name} must be a table")
        self._values: dict[str, Any] = dict(values)
        self._known: set[str] = set()

    def has(self, key: str) -> bool:
        """Whether the key is given."""
        return key in self._values

    def error(self, key: str, what: str) -> BadInput:
        """An error of this file and key."""
        place = f"{self.name}.{key}" if self.name else key
        return BadInput(f"{self.path}: {place} {what}")

    def number(self, key: str, low: float, high: float, default: Any = _MISSING) -> float:
        """A number from `low` to `high`."""
        value = self._get(key, default)
        if value is default:
            return value  # type: ignore[no-any-return]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:
            raise self.error(key, f"must be a number, not {value!r}")
        if not low <= value <= high:
            raise self.error(key, f"is {value:g}; it must lie from {low:g} to {high:g}")
        return float(value)

    def whole(self, key: str, low: int, high: int, default: Any = _MISSING) -> int:
        """A whole number from `low` to `high`."""
        value = self._get(key, default)
        if value is default:
            return value  # type: ignore[no-any-return]
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"must be a whole number, not {value!r}")
        return int(self.number(key, low, high))

    def text(self, key: str, default: Any = _MISSING) -> str:
        """Text, not empty."""
        value = self._get(key, default)
        if value is default:
            return value  # type: ignore[no-any-return]
        if not isinstance(value, str) or not value.strip():
            raise self.error(key, f"must be a text, not {value!r}")
        return value

    def word(self, key: str, choices: Sequence[str], default: Any = _MISSING) -> str:
        """One of a few words."""
        value = self.text(key, default)
        if value is not default and value not in choices:
            raise self.error(key, f"is {value!r}; it must be one of {', '.join(choices)}")
        return value

    def flag(self, key: str, default: Any = _MISSING) -> bool:
        """True or false."""
        value = self._get(key, default)
        if not isinstance(value, bool):
            raise self.error(key, f"must be true or false, not {value!r}")
        return value

    def texts(self, key: str, choices: Sequence[str], default: Any = _MISSING) -> tuple[str, ...]:
        """A list of words, not empty."""
        value = self._get(key, default)
        if value is default:
            return value  # type: ignore[no-any-return]
        if not isinstance(value, list) or not value or not all(isinstance(entry, str) for entry in value):
            raise self.error(key, f"must be a list of words, not {value!r}")
        for entry in value:
            if entry not in choices:
                raise self.error(key, f"holds {entry!r}; known are {', '.join(choices)}")
        return tuple(value)

    def numbers(self, key: str, count: int, default: Any = _MISSING) -> tuple[float, ...]:
        """A list of so many numbers."""
        value = self._get(key, default)
        if value is default:
            return value  # type: ignore[no-any-return]
        return self._row(key, value, count)

    def rows(self, key: str, count: int) -> tuple[tuple[float, ...], ...]:
        """A list of lists of so many numbers; empty when the key is missing."""
        value = self._get(key, [])
        if not isinstance(value, list):
            raise self.error(key, f"must be a list of lists of {count} numbers")
        return tuple(self._row(key, row, count) for row in value)

    def table(self, key: str) -> Table:
        """A table within this one; empty when the key is missing."""
        return Table(self.path, f"{self.name}.{key}" if self.name else key, self._get(key, {}))

    def tables(self, key: str) -> list[Table]:
        """A list of tables, `[[key]]`; empty when the key is missing."""
        value = self._get(key, [])
        if not isinstance(value, list):
            raise self.error(key, f"must be written as [[{key}]]")
        return [Table(self.path, f"{key}[{number}]", entry) for number, entry in enumerate(value, 1)]

    def raw(self, key: str, default: Any = _MISSING) -> Any:
        """Whatever is there."""
        return self._get(key, default)

    def names(self) -> list[str]:
        """All keys, in the order of the file."""
        return list(self._values)

    def done(self) -> None:
        """Call when all known keys were asked for."""
        for key in self._values:
            if key not in self._known:
                known = ", ".join(sorted(self._known))
                raise self.error(key, f"is not known here; known are {known}")

    def _get(self, key: str, default: Any) -> Any:
        self._known.add(key)
        if key in self._values:
            return self._values[key]
        if default is _MISSING:
            raise self.error(key, "is missing")
        return default

    def _row(self, key: str, value: Any, count: int) -> tuple[float, ...]:
        good = isinstance(value, list) and len(value) == count
        if not good or any(isinstance(entry, bool) or not isinstance(entry, (int, float)) for entry in value):
            raise self.error(key, f"must be a list of {count} numbers, not {value!r}")
        return tuple(float(entry) for entry in value)
