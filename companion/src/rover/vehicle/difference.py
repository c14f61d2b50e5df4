"""What differs between a vehicle file and a board, and what a board's values forbid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rover_protocol.parameters import BY_NAME


@dataclass(frozen=True)
class Difference:
    """A parameter in the firmware's own unit; board: None where the firmware does not know it."""

    name: str
    file: int
    board: int | None

    @property
    def safety(self) -> bool:
        """Whether the difference may let the rover hurt somebody, or drive where it does not mean to."""
        return BY_NAME[self.name].safety

    def __str__(self) -> str:
        unit = BY_NAME[self.name].unit
        board = "not known to this firmware" if self.board is None else f"{self.board}"
        return f"{self.name} {board}, {self.file} {unit} in the file"

    def as_dict(self) -> dict[str, Any]:
        """As `--json` tells it."""
        return {"name": self.name, "file": self.file, "board": self.board, "safety": self.safety}


def differences(file: Mapping[str, int], board: Mapping[str, int]) -> list[Difference]:
    """By parameter, in the order of the identifiers. What an old firmware lacks differs unless it is at its default."""
    found = []
    for name, wanted in file.items():
        there = board.get(name)
        if there != wanted and not (there is None and wanted == BY_NAME[name].default):
            found.append(Difference(name, wanted, there))
    return found


def left_from_a_bench(board: Mapping[str, int]) -> list[str]:
    """Values with which no rover may set off, each as a few words."""
    found = []
    for name, value in board.items():
        known = BY_NAME[name]
        if not known.start_minimum <= value <= known.start_maximum:
            found.append(
                f"{name} {value} {known.unit} (a rover sets off with {known.start_minimum} to {known.start_maximum})"
            )
    return found
