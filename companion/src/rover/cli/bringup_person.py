"""The person beside the rover, asked on a terminal."""

from __future__ import annotations

import math

import typer

from rover.bringup.helper import SENSORS, WHEELS
from rover.cli.output import say
from rover.errors import BadInput

SEEN = [f"{wheel} {way}" for wheel in WHEELS for way in ("forward", "back")] + ["nothing"]


class Person:
    """Every question goes to stderr; an answer that is no number is asked for again."""

    def __init__(self, voltmeter: float | None = None) -> None:
        """`voltmeter`: what it shows, when it is known beforehand."""
        self._voltmeter = voltmeter

    def ready(self, text: str) -> None:
        """Waits for Return."""
        _ask(f"{text}; then Return", "")

    def volts(self) -> float:
        """The meter's reading."""
        return self._voltmeter or _number("volts at the battery's terminals, by a meter", 0.5, 100.0)

    def emergency(self, pressed: bool) -> None:
        """By hand."""
        _ask("press the emergency stop, then Return" if pressed else "release it, then Return", "")

    def before(self) -> None:
        """A person remembers."""

    def moved(self, before: None) -> str:
        """One of five answers."""
        for number, answer in enumerate(SEEN, start=1):
            say(f"  {number} {answer}")
        return SEEN[int(_number("which wheel turned?", 1, len(SEEN))) - 1]

    def turns(self, before: None) -> tuple[float, float]:
        """Counted by a mark on the tyre."""
        left, right = (_number(f"turns of the {wheel} wheel, forward positive", -1000.0, 1000.0) for wheel in WHEELS)
        return left, right

    def straight(self, before: None) -> tuple[float, float]:
        """By a tape measure, and by how far it has come off the line at the end."""
        way = _number("metres that it has come, by the tape", 0.01, 100.0)
        aside = _number("by how many degrees its heading has changed, to the left positive", -180.0, 180.0)
        return way, math.radians(aside)

    def rotation(self, before: None, about: float) -> float:
        """Whole turns are known, the rest is measured."""
        turns = round(about / (2.0 * math.pi))
        rest = _number(f"degrees from its old heading after {turns} turns, to the left positive", -180.0, 180.0)
        return 2.0 * math.pi * turns + math.radians(rest)

    def box(self, sensor: int, distance: float) -> None:
        """A box that no other sensor sees."""
        _ask(f"a box {distance:g} m before the {SENSORS[sensor]} sensor, and before no other; then Return", "")

    def no_box(self) -> None:
        """Away with it."""
        _ask("take the box away, then Return", "")


def _ask(text: str, default: str | None = None) -> str:
    try:
        return str(typer.prompt(text, default=default, show_default=False, err=True))
    except (EOFError, typer.Abort):
        raise BadInput(
            "bringup: somebody has to answer; on a simulated rig --port is that of rover hil serve"
        ) from None


def _number(text: str, low: float, high: float) -> float:
    while True:
        answer = _ask(text)
        try:
            value = float(answer.replace(",", "."))
        except ValueError:
            value = math.nan
        if low <= value <= high:
            return value
        say(f"a number from {low:g} to {high:g} is expected, not {answer!r}")
