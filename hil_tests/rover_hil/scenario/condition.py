"""Conditions as a test engineer writes them: `state == Moving and travelled_m > 0.3`.

    condition  = all ("or" all)*
    all        = single ("and" single)*
    single     = "not" single | "(" condition ")" | name | name operator value
    operator   = == != < <= > >=
    value      = number | word

A name is an observable (see `observation.py`). Text is compared with words, numbers with numbers; a flag stands alone.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping

from rover.errors import BadInput

from rover_hil.scenario.observation import FLAGS, NUMBERS, WORDS, known_counter

Value = float | str | bool
Condition = Callable[[Mapping[str, Value]], bool]

TOKEN = re.compile(r"\s*(?:(?P<number>-?\d+(?:\.\d+)?)|(?P<word>[A-Za-z_][\w.-]*)|(?P<sign>==|!=|<=|>=|<|>|\(|\)))")
COMPARISONS: dict[str, Callable[[Value, Value], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def parse_condition(text: str) -> Condition:
    """A function of the observed values. Raises BadInput that says what is wrong and where."""
    parser = _Parser(text)
    condition = parser.alternatives()
    parser.expect_end()
    return condition


class _Parser:
    """Recursive descent over the tokens of one condition."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = _tokens(text)
        self._at = 0

    def alternatives(self) -> Condition:
        parts = [self._all()]
        while self._take("or"):
            parts.append(self._all())
        return parts[0] if len(parts) == 1 else lambda seen: any(part(seen) for part in parts)

    def expect_end(self) -> None:
        if self._at < len(self._tokens):
            raise self._error(f"'and' or 'or' is expected instead of {self._tokens[self._at]!r}")

    def _all(self) -> Condition:
        parts = [self._single()]
        while self._take("and"):
            parts.append(self._single())
        return parts[0] if len(parts) == 1 else lambda seen: all(part(seen) for part in parts)

    def _single(self) -> Condition:
        if self._take("not"):
            inner = self._single()
            return lambda seen: not inner(seen)
        if self._take("("):
            inside = self.alternatives()
            if not self._take(")"):
                raise self._error("a ) is missing")
            return inside
        name = self._next("the name of something observed")
        if name in FLAGS or name.startswith("fault."):
            self._check_fault(name)
            return lambda seen: bool(seen.get(name, False))
        return self._comparison(name)

    def _comparison(self, name: str) -> Condition:
        numeric = name in NUMBERS or name.startswith("count.")
        if not (numeric or name in WORDS):
            known = ", ".join(sorted([*NUMBERS, *WORDS, *FLAGS]))
            raise self._error(f"{name!r} is not observed; there is {known}, fault.NAME and count.NAME")
        self._check_fault(name)
        sign = self._next(f"a comparison after {name}")
        if sign not in COMPARISONS:
            raise self._error(f"a comparison (== != < <= > >=) is expected after {name}, not {sign!r}")
        value = self._value(name, self._next(f"a value after {sign}"), numeric)
        if not numeric and sign not in ("==", "!="):
            raise self._error(f"{name} is a word: only == and != compare it")
        compare = COMPARISONS[sign]
        absent: Value = 0.0 if numeric else ""
        return lambda seen: compare(seen.get(name, absent), value)

    def _value(self, name: str, text: str, numeric: bool) -> Value:
        if not numeric:
            words = WORDS[name]
            if text not in words:
                raise self._error(f"{name} is never {text!r}; it is one of {', '.join(words)}")
            return text
        try:
            return float(text)
        except ValueError:
            raise self._error(f"{name} is a number, {text!r} is not") from None

    def _check_fault(self, name: str) -> None:
        family, _, fault = name.partition(".")
        if fault and not known_counter(fault):
            raise self._error(f"{family}.{fault}: the protocol has no fault of that name")

    def _next(self, what: str) -> str:
        if self._at >= len(self._tokens):
            raise self._error(f"{what} is missing at the end")
        self._at += 1
        return self._tokens[self._at - 1]

    def _take(self, token: str) -> bool:
        found = self._at < len(self._tokens) and self._tokens[self._at] == token
        self._at += found
        return found

    def _error(self, what: str) -> BadInput:
        return BadInput(f"condition {self._text!r}: {what}")


def _tokens(text: str) -> list[str]:
    tokens: list[str] = []
    at = 0
    while text[at:].strip():
        match = TOKEN.match(text, at)
        if match is None:
            raise BadInput(f"condition {text!r}: {text[at:].split()[0]!r} is not understood")
        tokens.append(match.group(0).strip())
        at = match.end()
    return tokens
