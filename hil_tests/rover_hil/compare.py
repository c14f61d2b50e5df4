"""Two runs of one mission beside each other, as two rigs have driven it.

python -m rover_hil.compare runs/sitl runs/emulator

Paths are the true ones, compared at equal times and as curves; detections are matched one to one, nearest first, within
2 cm and of the same class. Exit code 1 when the runs are not alike.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover.record.tum import read_tum

# Metres within which paths and places count as the same.
MATCH_WITHIN_M = 0.02


@dataclass(frozen=True)
class Comparison:
    """Metres and counts; `at_equal_times_m`: over the time that both have driven."""

    status: tuple[str, str]
    duration_s: tuple[float, float]
    at_equal_times_m: float
    as_curves_m: float
    detections: tuple[int, int]
    detections_matched: int

    @property
    def alike(self) -> bool:
        """The same end, the same detections, and paths that lie within 2 cm of each other."""
        same = self.status[0] == self.status[1] and self.as_curves_m <= MATCH_WITHIN_M
        return same and self.detections == (self.detections_matched,) * 2


def compare(one: Path, other: Path) -> Comparison:
    """Two folders of runs on simulated rigs. Raises BadInput, OSError for what is not there."""
    paths = [read_tum(folder / "truth.tum")[:, 1:3] for folder in (one, other)]
    told: list[dict[str, Any]] = [json.loads((folder / "summary.json").read_text()) for folder in (one, other)]
    common = min(map(len, paths))
    found = [summary["detections"] for summary in told]
    return Comparison(
        status=(told[0]["status"], told[1]["status"]),
        duration_s=(told[0]["duration_s"], told[1]["duration_s"]),
        at_equal_times_m=float(np.hypot(*(paths[0][:common] - paths[1][:common]).T).max()),
        as_curves_m=max(farthest(paths[0], paths[1]), farthest(paths[1], paths[0])),
        detections=(len(found[0]), len(found[1])),
        detections_matched=matched(found[0], found[1]),
    )


def farthest(path: NDArray[np.float64], from_path: NDArray[np.float64]) -> float:
    """Greatest distance of a point of one path (n, 2) from the nearest of the other (m, 2), every tenth looked at."""
    return max((float(np.hypot(*(from_path - point).T).min()) for point in path[::10]), default=0.0)


def matched(one: list[dict[str, Any]], other: list[dict[str, Any]]) -> int:
    """How many places can be paired, each once, with one of the same class within 2 cm."""
    pairs = sorted(
        (math.hypot(a["x"] - b["x"], a["y"] - b["y"]), i, j)
        for i, a in enumerate(one)
        for j, b in enumerate(other)
        if a["class"] == b["class"]
    )
    first: set[int] = set()
    second: set[int] = set()
    for distance, i, j in pairs:
        if distance <= MATCH_WITHIN_M and i not in first and j not in second:
            first.add(i)
            second.add(j)
    return len(first)


def main(argv: list[str] | None = None) -> int:
    """Prints one line of JSON; returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m rover_hil.compare", description=__doc__, formatter_class=raw)
    parser.add_argument("one", type=Path, help="folder of a run")
    parser.add_argument("other", type=Path, help="folder of another")
    given = parser.parse_args(argv)
    comparison = compare(given.one, given.other)
    print(json.dumps({"alike": comparison.alike, **asdict(comparison)}))
    return 0 if comparison.alike else 1


if __name__ == "__main__":
    raise SystemExit(main())
