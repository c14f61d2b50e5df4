"""Typed, bounded values out of a TOML file that a person wrote; every mistake becomes one line that names its key.

Missions, cameras, vehicles, fields and scenarios are all read through `Table`. Every reader takes the key first, then
what the value may be, then the default; a key without a default must be there. Each raises BadInput.
"""

from __future__ import annotations

import datetime
import difflib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.toml_file import printable, read_toml

# A key's last part names its unit; a mistaken unit is the commonest slip in a hand-written file.
UNITS = (
    *("m", "cm", "mm", "m2", "deg", "rad", "s", "ms", "min"),
    *("m_s", "m_s2", "m_s3", "km_h", "cm_s", "rad_s", "rad_s2", "rad_s3", "deg_s"),
)

# Characters of a wrong value that its line shows.
MAX_SHOWN = 40

OUTLINE = "a list of points [x, y]"


class Table:
    """One table of a file, `name` as in its header; "" for the file itself.

    A key that nobody reads is refused (`only`): a setting that is silently ignored is one that the user believes in.
    """

    def __init__(self, path: Path, values: object, name: str = "") -> None:
        self.path, self.name = path, name
        if not isinstance(values, dict):
            raise BadInput(f"{path}: [{printable(name)}] must be a table")
        self._values: dict[str, Any] = values

    @classmethod
    def of_file(cls, path: Path) -> Table:
        """The whole file."""
        return cls(path, read_toml(path))

    def only(self, *known: str) -> Table:
        """This table, which has no other keys than these."""
        for key in self._values:
            if key not in known:
                raise self.error(key, "unknown key" + _suggestion(key, known))
        return self

    def error(self, key: str, why: str) -> BadInput:
        """The error to raise for a value that only the caller can judge."""
        place = f"[{printable(self.name)}] " if self.name else ""
        return BadInput(f"{self.path}: {place}{printable(key)}: {why}")

    def has(self, key: str) -> bool:
        """Whether the key is there."""
        return key in self._values

    def holds_text(self, key: str) -> bool:
        """Whether the key is there with a string."""
        return isinstance(self._values.get(key), str)

    @property
    def values(self) -> dict[str, Any]:
        """All of it, as it is."""
        return self._values

    def names(self) -> list[str]:
        """All keys, in the order of the file."""
        return list(self._values)

    # -- one value -----------------------------------------------------------------------------------------------

    def number(self, key: str, low: float, high: float, default: float | None = None) -> float:
        """A finite number within [low, high]; the unit is in the key's name."""
        return self._bounded(key, self._take(key, default), low, high)

    def integer(self, key: str, low: int, high: int, default: int | None = None) -> int:
        """A whole number within [low, high]."""
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"must be a whole number, not {_shown(value)}")
        if not low <= value <= high:
            raise self.error(key, f"{_shown(value)} lies outside {low} to {high}")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """Text; blank only where that is the default."""
        value = self._take(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"must be a string in quotes, not {_shown(value)}")
        if not value.strip() and value != default:
            raise self.error(key, "must not be blank")
        return value

    def choice(self, key: str, choices: Sequence[str], default: str | None = None) -> str:
        """One of a few words."""
        value = self.text(key, default)
        if value not in choices:
            raise self.error(key, f"{_shown(value)} is not one of {', '.join(choices)}{_nearest(value, choices)}")
        return value

    def flag(self, key: str, default: bool | None = None) -> bool:
        """True or false."""
        value = self._take(key, default)
        if not isinstance(value, bool):
            raise self.error(key, f"must be true or false, not {_shown(value)}")
        return value

    def clock_time(self, key: str, default: str | None = None) -> float:
        """Time of day "hh:mm" in seconds since midnight."""
        value = self.text(key, default)
        if not re.fullmatch(r"([01]?[0-9]|2[0-3]):[0-5][0-9]", value):
            raise self.error(key, f'{_shown(value)} is not a time of day like "13:00"')
        hours, _, minutes = value.partition(":")
        return int(hours) * 3600.0 + int(minutes) * 60.0

    # -- several values ------------------------------------------------------------------------------------------

    def date(self, key: str) -> datetime.date:
        """A day, in quotes or as TOML writes it."""
        value = self._take(key, None)
        if isinstance(value, datetime.date) and not isinstance(value, datetime.datetime):
            return value
        try:
            return datetime.date.fromisoformat(value)
        except (TypeError, ValueError):
            raise self.error(key, f'{_shown(value)} is not a date like "2026-06-21"') from None

    def numbers(self, key: str, low: float, high: float, default: Sequence[float] | None = None) -> tuple[float, ...]:
        """A list of numbers, each within [low, high]."""
        values = self._list(key, "a list of numbers", default)
        return tuple(self._bounded(key, value, low, high) for value in values)

    def row(
        self, key: str, names: Sequence[str], low: float, high: float, default: Sequence[float] | None = None
    ) -> tuple[float, ...]:
        """A list of so many numbers as there are names, each within [low, high]."""
        return self._row(key, "", self._take(key, default), names, low, high)

    def rows(self, key: str, names: Sequence[str], low: float, high: float) -> tuple[tuple[float, ...], ...]:
        """A list of such lists, as of points or circles; empty when absent."""
        values = self._list(key, f"a list of [{', '.join(names)}]", ())
        return tuple(self._row(key, f" entry {n}", row, names, low, high) for n, row in enumerate(values, start=1))

    def outline(self, key: str, low: float, high: float) -> tuple[tuple[float, float], ...]:
        """A polygon: at least three different points [x, y], its last edge leads back to the first."""
        return self._outline(key, self._list(key, OUTLINE, None), low, high)

    def outlines(self, key: str, low: float, high: float) -> tuple[tuple[tuple[float, float], ...], ...]:
        """A list of polygons; empty when absent."""
        polygons = self._list(key, f"a list of polygons, each {OUTLINE}", ())
        return tuple(self._outline(f"{key} entry {n}", points, low, high) for n, points in enumerate(polygons, start=1))

    def choices(self, key: str, choices: Sequence[str], default: Sequence[str] | None = None) -> tuple[str, ...]:
        """A list of words, not empty."""
        values = self._list(key, "a list of words", default)
        if not values and default is None:
            raise self.error(key, "must name at least one")
        for value in values:
            if not isinstance(value, str):
                raise self.error(key, f"must be a list of words, not {_shown(values)}")
            if value not in choices:
                raise self.error(key, f"{_shown(value)} is not one of {', '.join(choices)}{_nearest(value, choices)}")
        return tuple(values)

    def table(self, key: str) -> Table:
        """A table within this one; empty when absent."""
        return Table(self.path, self._values.get(key, {}), self._name_of(key))

    def tables(self, key: str) -> list[Table]:
        """A list of tables, as by `[[key]]`; empty when absent."""
        values = self._list(key, f"a list of tables, [[{key}]]", ())
        return [Table(self.path, value, f"{self._name_of(key)} {n}") for n, value in enumerate(values, start=1)]

    # -- what they share -----------------------------------------------------------------------------------------

    def _name_of(self, key: str) -> str:
        return f"{self.name}.{key}" if self.name else key

    def _take(self, key: str, default: object) -> Any:
        if key in self._values:
            return self._values[key]
        if default is None:
            raise self.error(key, "missing")
        return default

    def _list(self, key: str, what: str, default: Sequence[object] | None) -> list[Any]:
        value = self._take(key, default)
        if not isinstance(value, (list, tuple)):
            raise self.error(key, f"must be {what}, not {_shown(value)}")
        return list(value)

    def _outline(self, key: str, points: object, low: float, high: float) -> tuple[tuple[float, float], ...]:
        if not isinstance(points, (list, tuple)):
            raise self.error(key, f"must be {OUTLINE}, not {_shown(points)}")
        rows = (self._row(key, f" point {n}", point, ("x", "y"), low, high) for n, point in enumerate(points, start=1))
        outline = tuple((x, y) for x, y in rows)
        if len(set(outline)) < 3:
            raise self.error(key, f"must have at least 3 different points, not {len(set(outline))}")
        return outline

    def _row(
        self, key: str, entry: str, value: object, names: Sequence[str], low: float, high: float
    ) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)) or len(value) != len(names):
            raise self.error(f"{key}{entry}", f"must be [{', '.join(names)}], not {_shown(value)}")
        return tuple(self._bounded(f"{key}{entry}", item, low, high) for item in value)

    def _bounded(self, key: str, value: object, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            unit = _unit(key)
            raise self.error(key, f"must be a number{f' in {unit}' if unit else ''}, not {_shown(value)}")
        # A whole number may be too large for a float: compare before converting.
        if not low <= value <= high:
            raise self.error(key, f"{_shown(value)} lies outside {low:g} to {high:g} {_unit(key)}".rstrip())
        return float(value)


def _shown(value: object) -> str:
    """A value as Python writes it, cut short."""
    try:
        text = repr(value)
    except ValueError:  # a number of thousands of digits, written in hexadecimal
        return "a huge number"
    return text if len(text) <= MAX_SHOWN else f"{text[:MAX_SHOWN]}…"


def _ending(key: str) -> str:
    """The unit at a key's end as the file spells it; "" where there is none."""
    return max((unit for unit in UNITS if key.endswith("_" + unit)), key=len, default="")


def _unit(key: str) -> str:
    """The same as people write it."""
    return _ending(key).replace("_s", "/s").replace("_h", "/h").replace("2", "²").replace("3", "³")


def _stem(key: str) -> str:
    """A key without its unit."""
    return key[: -len(_ending(key)) - 1] if _ending(key) else key


def _suggestion(key: str, known: Sequence[str]) -> str:
    same = [candidate for candidate in known if _ending(key) and _stem(candidate) == _stem(key)]
    if same:
        return f"; wrong unit? it is {same[0]} here"
    return _nearest(key, known) or f"; known are {', '.join(known)}"


def _nearest(word: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(word, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""
