"""Whether two texts say the same: word for word, and number for number within a tolerance."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from itertools import zip_longest

# A hyphen or minus right behind a letter, digit or underscore joins words (`small-3`) or bounds (`2–5`): no sign.
NUMBER = re.compile(r"(?<![\w.])[-−+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Tolerance:
    """How far two numbers may lie apart: `relative` to the larger one, or `absolute`, whichever allows more."""

    relative: float = 0.0
    absolute: float = 0.0

    def allows(self, one: float, other: float) -> bool:
        """True when the two count as equal."""
        # The slack is for decimal figures that are not exact in binary: 0.3 - 0.2 is above 0.1.
        return math.isclose(one, other, rel_tol=self.relative + 1e-12, abs_tol=self.absolute * (1.0 + 1e-9))


EXACT = Tolerance()


def read_tolerance(text: str) -> Tolerance:
    """`2%` or `0.1`. Raises ValueError."""
    try:
        value = float(text.removesuffix("%"))
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise ValueError(f"a tolerance is a share like 2% or a number like 0.1, not `{text}`")
    return Tolerance(relative=value / 100.0) if text.endswith("%") else Tolerance(absolute=value)


def first_difference(written: str, printed: str, tolerance: Tolerance = EXACT) -> str | None:
    """The first line in which they differ, in words; None when they agree. Blank lines and columns' widths are free."""
    pairs = zip_longest(_lines(written), _lines(printed))
    for there, here in pairs:
        if there is None:
            return f"the page lacks `{here}`"
        if here is None:
            return f"the page has `{there}`, which is no longer printed"
        if not _agree(there, here, tolerance):
            return f"the page has `{there}`, printed is `{here}`"
    return None


def _lines(text: str) -> list[str]:
    # A table may be laid out by hand: neither blanks nor the rule under its head count.
    lines = (" ".join(re.sub(r"-{2,}", "--", line).split()) for line in text.splitlines())
    return [line for line in lines if line]


def _agree(one: str, other: str, tolerance: Tolerance) -> bool:
    numbers, others = NUMBER.findall(one), NUMBER.findall(other)
    if NUMBER.sub("0", one) != NUMBER.sub("0", other) or len(numbers) != len(others):
        return False
    return all(tolerance.allows(_value(a), _value(b)) for a, b in zip(numbers, others, strict=True))


def _value(text: str) -> float:
    return float(text.replace("−", "-"))
