"""Reading typed, bounded values out of TOML tables, so that a mistake becomes one line that names it."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.toml_file import printable

# A key's last part names its unit; a mistaken unit is the commonest slip in a hand-written file.
UNITS = ("m", "cm", "mm", "deg", "rad", "s", "ms", "min", "m_s", "km_h", "cm_s")


def _stem(key: str) -> str:
    """A key without the unit at its end."""
    endings = [unit for unit in UNITS if key.endswith("_" + unit)]
    return key[: -len(max(endings, key=len)) - 1] if endings else key


class Table:
    """One table of a document: refuses keys that it does not know, hands out checked values.

    A key that is silently ignored is a setting that the user believes in.
    """

    def __init__(self, path: Path, name: str, values: Any, known: tuple[str, ...]) -> None:
        if not isinstance(values, dict):
            raise BadInput(f"{path}: [{name}] must be a table")
        self._path, self._name, self._values, self._known = path, name, values, known
        for key in values:
            if key not in known:
                raise self._fail(key, "unknown key" + self._suggest(key))

    def _fail(self, key: str, why: str) -> BadInput:
        return BadInput(f"{self._path}: [{self._name}] {printable(key)}: {why}")

    def fail(self, key: str, why: str) -> BadInput:
        """The error to raise for a value that only the caller can judge."""
        return self._fail(key, why)

    def _take(self, key: str, default: Any) -> Any:
        if key in self._values:
            return self._values[key]
        if default is None:
            raise self._fail(key, "missing")
        return default

    def number(self, key: str, default: float | None, low: float, high: float) -> float:
        """A finite number within [low, high]; the unit is in the key's name."""
        value = self._take(key, default)
        return self._bounded(key, value, low, high)

    def _bounded(self, key: str, value: Any, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._fail(key, f"must be a number{self._unit_of(key)}, not {value!r}")
        # A whole number may be too large for a float: compare before converting.
        if not low <= value <= high:
            raise self._fail(key, f"{str(value)[:24]} lies outside {low:g} to {high:g}{self._unit_of(key)}")
        return float(value)

    @staticmethod
    def _unit_of(key: str) -> str:
        for unit in sorted(UNITS, key=len, reverse=True):
            if key.endswith("_" + unit):
                return " " + unit.replace("m_s", "m/s")
        return ""

    def integer(self, key: str, default: int | None, low: int, high: int) -> int:
        """A whole number within [low, high]."""
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self._fail(key, f"must be a whole number, not {value!r}")
        if not low <= value <= high:
            raise self._fail(key, f"{str(value)[:24]} lies outside {low} to {high}")
        return value

    def text(self, key: str, default: str | None) -> str:
        """A string."""
        value = self._take(key, default)
        if not isinstance(value, str):
            raise self._fail(key, f"must be a string in quotes, not {value!r}")
        return value

    def choice(self, key: str, default: str, choices: tuple[str, ...]) -> str:
        """One of the given strings."""
        value = self.text(key, default)
        if value not in choices:
            raise self._fail(key, f"{value!r} is not one of {', '.join(choices)}")
        return value

    def clock_time(self, key: str, default: str) -> float:
        """Time of day "hh:mm" in seconds since midnight."""
        value = self.text(key, default)
        if not re.fullmatch(r"([01]?[0-9]|2[0-3]):[0-5][0-9]", value):
            raise self._fail(key, f'{value!r} is not a time of day like "13:00"')
        hours, _, minutes = value.partition(":")
        return int(hours) * 3600.0 + int(minutes) * 60.0

    def tuples(self, key: str, names: tuple[str, ...], low: float, high: float) -> tuple[tuple[float, ...], ...]:
        """A list of equally long lists of numbers, such as points or circles; empty when absent."""
        value = self._take(key, [])
        shape = f"a list of [{', '.join(names)}]"
        if not isinstance(value, list):
            raise self._fail(key, f"must be {shape}, not {value!r}")
        rows = []
        for number, row in enumerate(value, start=1):
            if not isinstance(row, list) or len(row) != len(names):
                raise self._fail(key, f"entry {number} must be [{', '.join(names)}], not {row!r}")
            rows.append(tuple(self._bounded(f"{key} entry {number}", item, low, high) for item in row))
        return tuple(rows)

    def numbers(self, key: str, default: list[float], low: float, high: float) -> tuple[float, ...]:
        """A list of numbers, each within [low, high]."""
        value = self._take(key, default)
        if not isinstance(value, list):
            raise self._fail(key, f"must be a list of numbers, not {value!r}")
        return tuple(self._bounded(key, item, low, high) for item in value)

    def _suggest(self, key: str) -> str:
        same = [known for known in self._known if _stem(known) == _stem(key) != known]
        if same and _stem(key) != key:
            return f"; wrong unit? it is {same[0]} here"
        near = difflib.get_close_matches(key, self._known, n=1)
        return f"; did you mean {near[0]}?" if near else f"; known are {', '.join(self._known)}"
