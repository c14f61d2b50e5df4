"""What people say of indications: a journal beside the run that only grows.

Nothing said here changes a zone, a goal or the report's list: an indication that somebody rejects stays in the record,
and its ground stays out of the wheels' reach. There is no word here for ground that holds nothing.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from rover.console.audit import now_utc
from rover.console.sessions import Refused, Session
from rover.mission.run_folder import JUDGEMENTS
from rover.str_enum import StrEnum

MAX_NOTE = 500
MAX_LINES = 2000


class Verdict(StrEnum):
    """confirmed: it looks like a mine. rejected: it looks like something else. marked: seen by a person, by hand."""

    CONFIRMED = "confirmed"
    REJECTED = "rejected"
    MARKED = "marked"


def read_judgements(folder: Path) -> list[dict[str, Any]]:
    """All of a run, the oldest first; a line that a dying process cut off is left out."""
    lines = []
    try:
        written = (folder / JUDGEMENTS).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    for line in written:
        try:
            lines.append(json.loads(line))
        except ValueError:
            continue
    return [line for line in lines if isinstance(line, dict)]


def judge(folder: Path, session: Session, content: dict[str, Any], places: set[int]) -> dict[str, Any]:
    """Adds one. `places`: numbers of the run's indications. Raises Refused for what is none."""
    try:
        verdict = Verdict(str(content.get("verdict")))
    except ValueError:
        raise Refused(f"a verdict is one of {', '.join(Verdict)}", 400) from None
    entry: dict[str, Any] = {"utc": now_utc(), "author": session.name, "verdict": verdict}
    if verdict is Verdict.MARKED:
        entry |= {"x": _metres(content.get("x")), "y": _metres(content.get("y"))}
    else:
        place = content.get("place")
        if not isinstance(place, int) or place not in places:
            raise Refused("there is no such indication", 404)
        entry["place"] = place
    note = content.get("note", "")
    entry["note"] = " ".join(str(note).split())[:MAX_NOTE]
    if len(read_judgements(folder)) >= MAX_LINES:
        raise Refused("this run's journal is full", 400)
    line = json.dumps(entry, ensure_ascii=False) + "\n"
    with open(
        os.open(folder / JUDGEMENTS, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644), "a", encoding="utf-8"
    ) as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())
    return entry


def _metres(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value) or abs(value) > 1e4:
        raise Refused("a mark needs x and y in metres", 400)
    return round(float(value), 4)
