"""What `--resume` needs, left in the run's folder while the rover drives: a companion that dies loses seconds.

Between two cycles only what changes is copied; a thread of its own packs it and waits for the disk. A large field takes
longer to pack, and is packed less often for it. Nothing that is decided depends on it.
"""

from __future__ import annotations

import shutil
import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from rover.mission.former_run import Learned, learned
from rover.mission.survey import Survey
from rover.whole_file import write_whole

# Mission time between two checkpoints, seconds: with a slow disk at most twice as much is lost.
PERIOD_S = 5.0
# Share of the time that packing may take.
PACKING_SHARE = 0.02

# Left on the disk for log, report and survey of a mission that ends because there is no more.
RESERVE_BYTES = 32_000_000


class Checkpoint:
    """Of one run. Use it as a context manager: leaving waits for the disk."""

    def __init__(self, survey: Survey, folder: Path) -> None:
        self._survey = survey
        self._folder = folder
        self._due = PERIOD_S
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="checkpoint")
        self._written: Future[float] | None = None

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.shutdown(wait=True)

    def keep(self, now: float) -> str | None:
        """Called every cycle. Returns why nothing more can be kept, None while all is well."""
        if now < self._due or (self._written is not None and not self._written.done()):
            return None
        error = self._written.exception() if self._written is not None else None
        took = self._written.result() if self._written is not None and error is None else 0.0
        self._due = now + max(PERIOD_S, took / PACKING_SHARE)
        if isinstance(error, OSError):
            return f"what has been surveyed cannot be written to {self._folder}: {error.strerror or error}"
        free = shutil.disk_usage(self._folder).free
        if free < RESERVE_BYTES:
            return f"the disk is nearly full: {free / 1e6:.0f} MB are left for {self._folder}"
        known = learned(self._survey)
        self._written = self._writer.submit(_write, self._folder, known) if known is not None else None
        return None


def _write(folder: Path, known: Learned) -> float:
    """Packs and writes; processor time of the packing, seconds."""
    begin = time.thread_time()
    files = known.packed()
    took = time.thread_time() - begin
    for name, content in files.items():
        write_whole(folder / name, content)
    return took
