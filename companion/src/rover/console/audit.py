"""Who did what, and what came of it: a line of JSON for each, appended and never changed."""

from __future__ import annotations

import json
import os
import threading
from datetime import datetime, timezone
from pathlib import Path

from rover.console.sessions import Session

FILE = "audit.jsonl"
# A full one is kept as audit.1.jsonl, and the one before that goes.
MAX_BYTES = 10 * 2**20


class Audit:
    """The log of one console's folder."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self._lock = threading.Lock()

    def note(self, who: Session | None, address: str, what: str, about: str = "", answer: str = "ok") -> None:
        """One line; a disk that is full stops nobody from stopping the rover."""
        line = {
            "utc": now_utc(),
            "who": None if who is None else who.name,
            "session": None if who is None else who.number,
            "role": None if who is None else who.role,
            "address": address,
            "what": what,
            "about": about[:500],
            "answer": answer[:500],
        }
        with self._lock:
            try:
                if self.path.exists() and self.path.stat().st_size > MAX_BYTES:
                    os.replace(self.path, self.path.with_name("audit.1.jsonl"))
                with open(
                    os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600), "a", encoding="utf-8"
                ) as log:
                    log.write(json.dumps(line, ensure_ascii=False) + "\n")
            except OSError:
                return


def now_utc() -> str:
    """Now, as ISO 8601 in UTC, to the millisecond."""
    return datetime.now(timezone.utc).isoformat(timespec="milliseconds").replace("+00:00", "Z")
