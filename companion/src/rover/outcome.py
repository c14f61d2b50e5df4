"""How a mission ended: the statuses of summary.json, each with its exit code."""

from __future__ import annotations

from dataclasses import dataclass

from rover.errors import Aborted, LinkLost, NoPath, SafetyStop
from rover.str_enum import StrEnum


class RunStatus(StrEnum):
    """Every way in which a mission can end."""

    DONE = "done"
    NO_PATH = "no_path"
    ABORTED = "aborted"
    SAFETY_STOP = "safety_stop"
    LINK_LOST = "link_lost"
    PARTIAL = "partial"

    @property
    def exit_code(self) -> int:
        """Exit code of the command that drove the mission."""
        return EXIT_CODES[self]


EXIT_CODES = {
    RunStatus.DONE: 0,
    RunStatus.NO_PATH: NoPath.exit_code,
    RunStatus.ABORTED: Aborted.exit_code,
    RunStatus.SAFETY_STOP: SafetyStop.exit_code,
    RunStatus.LINK_LOST: LinkLost.exit_code,
    RunStatus.PARTIAL: 8,
}


@dataclass(frozen=True)
class Outcome:
    """A status, and one sentence that tells the operator why."""

    status: RunStatus
    reason: str

    def __post_init__(self) -> None:
        if not self.reason.strip():
            raise ValueError(f"{self.status}: an end without a reason")
