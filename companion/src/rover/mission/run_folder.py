"""The folder of a run: its own, locked while the run lasts, and never at the cost of what lay there before.

Nothing that a run may leave is deleted or made before its pre-flight check has passed.
"""

from __future__ import annotations

import fcntl
import os
import re
from datetime import datetime
from pathlib import Path

from rover.errors import BadInput
from rover.mission.ear import SOCKET
from rover.mission.former_run import FILES as FORMER_FILES
from rover.record.manifest import MANIFEST, SIGNATURE
from rover.report.geojson import LOCAL_FILE, WORLD_FILE
from rover.report.imsma import FILE as CSV_FILE
from rover.report.kml import WORLD_FILE as KML_FILE
from rover.report.pdf import FILE as PDF_FILE

RUNS = Path("runs")
# Characters of a mission's name that its folders carry.
MAX_NAME = 80
RIG_LOG = "rig.log"
# What people say of a run's indications, see `rover.console.judgement`.
JUDGEMENTS = "judgements.jsonl"
# What the rig says until the pre-flight check has passed.
_RIG_LOG_BEFORE = ".rig.log.part"

# All that a run may leave: with --force these go, and nothing else.
RUN_FILES = (
    "mission.mcap",
    "summary.json",
    "report.html",
    "map.png",
    "map.pgm",
    "map.yaml",
    WORLD_FILE,
    LOCAL_FILE,
    KML_FILE,
    CSV_FILE,
    PDF_FILE,
    "trajectory.tum",
    JUDGEMENTS,
    *FORMER_FILES,
    "truth.tum",
    "truth.json",
    "truth_seen.npz",
    "rig.json",
    SOCKET,
    RIG_LOG,
    MANIFEST,
    SIGNATURE,
)


def new_folder(mission: str, now: datetime, runs: Path = RUNS) -> Path:
    """A name in `runs` that no run has had: date, time and mission. `now`: local time."""
    name = re.sub(r"[^\w.-]+", "-", mission)[:MAX_NAME].strip("-.") or "mission"
    stem = f"{now:%Y%m%d-%H%M%S}-{name}"
    names = (stem if number == 1 else f"{stem}-{number}" for number in range(1, 10_000))
    return next(runs / each for each in names if not (runs / each).exists())


def check_free(path: Path, force: bool) -> None:
    """Raises BadInput for a path that is no folder, is in use, or holds something and is not to be written over."""
    if path.exists() and not path.is_dir():
        raise BadInput(f"--out {path}: cannot be made a folder: a file is there")
    if path.is_dir():
        folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            _lock(folder, path)
        finally:
            os.close(folder)
        _check_empty(path, force)


def _check_empty(path: Path, force: bool) -> None:
    if not force and any(entry.name != _RIG_LOG_BEFORE for entry in path.iterdir()):
        raise BadInput(f"--out {path}: is not empty; name a new folder, or replace the run that is there by --force")


def _lock(folder: int, path: Path) -> None:
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise BadInput(f"--out {path}: another run is writing there; name another folder") from None


class RunFolder:
    """Use it as a context manager: without `accept` all is afterwards as it was before."""

    def __init__(self, path: Path, force: bool = False) -> None:
        """Claims the folder. `force`: what an earlier run left there may go.

        Raises BadInput for a folder that cannot be made, holds something, or belongs to a run that still lasts.
        """
        self.path = path
        self._accepted = False
        self._made = [folder for folder in (path, *path.parents) if not folder.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        except OSError as error:
            raise BadInput(f"--out {path}: cannot be made a folder: {error.strerror or error}") from error
        try:
            self._check(force)
        except BaseException:
            self._release()
            raise

    def _check(self, force: bool) -> None:
        _lock(self._lock, self.path)
        _check_empty(self.path, force)

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        if not self._accepted:
            self._unmake()
        self._release()

    @property
    def rig_log(self) -> Path:
        """Where a simulated rig's messages go."""
        return self.path / (RIG_LOG if self._accepted else _RIG_LOG_BEFORE)

    def accept(self) -> None:
        """The pre-flight check has passed: what an earlier run left goes, and this one's files may be made."""
        for name in RUN_FILES:
            (self.path / name).unlink(missing_ok=True)
        if self.rig_log.exists():
            os.replace(self.rig_log, self.path / RIG_LOG)
        self._accepted = True

    def _unmake(self) -> None:
        self.rig_log.unlink(missing_ok=True)
        for folder in self._made:
            try:
                folder.rmdir()
            except OSError:  # somebody has put something there meanwhile
                return

    def _release(self) -> None:
        os.close(self._lock)
