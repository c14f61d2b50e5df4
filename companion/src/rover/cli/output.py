"""Data on stdout, messages on stderr. A reader that has gone away ends the output, not the mission."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import unicodedata
from typing import Any, TextIO

TURNING = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def write_text(text: str) -> None:
    """`text` and a newline on stdout; nothing when nobody reads it any more."""
    _write(sys.stdout, printable(text))


def write_json(document: Any) -> None:
    """One JSON document on stdout; what JSON has no number for (nan, infinities) becomes null."""
    write_text(json.dumps(_finite(document), indent=2, ensure_ascii=False))  # JSON has the same escapes


def say(text: str) -> None:
    """One line on stderr that begins with the program's name, whatever line breaks `text` holds."""
    _write(sys.stderr, f"rover: {printable(' '.join(text.split()))}")


def printable(text: str) -> str:
    """`text` with escapes for control characters, but newline and tabulator, and for marks that turn writing round.

    Names of files, what stands in them and what a board says may hold commands to a terminal.
    """
    return "".join(_escaped(c) if c not in "\n\t" and _is_control(c) else c for c in text)


def _is_control(character: str) -> bool:
    return unicodedata.category(character) == "Cc" or character in TURNING


def _escaped(character: str) -> str:
    return f"\\u{ord(character):04x}"


def silence(stream: TextIO) -> None:
    """Sends what is still buffered for a closed pipe to nowhere, so that the interpreter's exit does not complain."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _write(stream: TextIO, text: str) -> None:
    try:
        stream.write(text + "\n")
        stream.flush()
    except UnicodeEncodeError:
        encoding = stream.encoding or "ascii"
        stream.write(text.encode(encoding, "replace").decode(encoding) + "\n")
        stream.flush()
    except OSError:  # a closed pipe, a terminal that has hung up
        silence(stream)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
