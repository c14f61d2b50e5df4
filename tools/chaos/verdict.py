"""What has to hold of every command, whatever it was given: a list of complaints, empty when all is well."""

from __future__ import annotations

import unicodedata
from pathlib import Path

from rover.errors import EXIT_CODES

from tools.chaos.process import Ended

PREFIX = "rover: "
UNEXPECTED = 1
BAD_INPUT = 2
# Refused before anything began: a line of its own says why.
REFUSED = (BAD_INPUT, 3)


def complaints(ended: Ended, limit_s: float, limit_mb: float, codes: tuple[int, ...] = tuple(EXIT_CODES)) -> list[str]:
    """`codes`: those that are right here."""
    found = []
    said = ended.out + ended.err
    if ended.code is None:
        found.append(f"had not ended after {limit_s:g} s")
    elif ended.code == UNEXPECTED:
        found.append(f"unexpected error: {_last(ended.err)}")
    elif ended.code not in codes or ended.code not in EXIT_CODES:
        found.append(f"exit code {ended.code}: {_last(said)}")
    if "Traceback (most recent call last)" in said:
        found.append(f"traceback: {_last(said)}")
    if ended.memory_mb > limit_mb:
        found.append(f"{ended.memory_mb:.0f} MB of memory, more than {limit_mb:g}")
    if raw := sorted({f"U+{ord(letter):04X}" for letter in said if _commands_a_terminal(letter)}):
        found.append(f"control characters in what it says: {', '.join(raw)}")
    if ended.code in REFUSED:
        lines = ended.err.splitlines()
        if strange := [line for line in lines if not line.startswith(PREFIX)]:
            found.append(f"a line that is not its own: {strange[0][:120]}")
        elif ended.code == BAD_INPUT and len(lines) != 1:  # a pre-flight check has a line for each thing
            found.append(f"{len(lines)} lines instead of one: {lines[:3]}")
    return found


def missing(run: Path) -> list[str]:
    """What a run that has ended should have left."""
    return [f"{name} is missing" for name in ("summary.json", "report.html") if not (run / name).exists()]


def _commands_a_terminal(letter: str) -> bool:
    return letter not in "\n\t" and unicodedata.category(letter) == "Cc"


def _last(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1][:200] if lines else "it said nothing"
