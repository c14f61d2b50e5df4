"""The folder of a run: complete when the rover may set off, as it was before when it may not."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from rover.errors import BadInput
from rover.mission.former_run import FILES as FORMER_FILES
from rover.report.geojson import LOCAL_FILE, WORLD_FILE

RIG_LOG = "rig.log"
WRITTEN = (
    "mission.mcap", "summary.json", "report.html", "map.png", WORLD_FILE, LOCAL_FILE, "trajectory.tum", *FORMER_FILES,
    "truth.tum", "truth.json", "truth_seen.npz", "rig.json", RIG_LOG,
)  # fmt: skip
"""Files that a run leaves in its folder, or some of them."""


class RunFolder:
    """Makes the folder; what was made goes again when an error comes before `begin`. Raises BadInput."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._made: list[Path] = []
        self._begun = False

    def __enter__(self) -> RunFolder:
        self._made = [folder for folder in (self.path, *self.path.parents) if not folder.exists()]
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput(f"--out {self.path}: cannot be made a folder: {error.strerror or error}") from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._begun:
            return
        self.starting_log.unlink(missing_ok=True)
        for folder in self._made:  # the innermost first
            if not any(folder.iterdir()):
                folder.rmdir()

    @property
    def starting_log(self) -> Path:
        """What a rig says goes here until `begin`, then into RIG_LOG."""
        return self.path / f".{RIG_LOG}"

    def begin(self) -> None:
        """The rover may set off: files of an earlier run in this folder must not be taken for this one's."""
        self._begun = True
        for name in WRITTEN:
            (self.path / name).unlink(missing_ok=True)
        if self.starting_log.exists():
            self.starting_log.rename(self.path / RIG_LOG)
