"""Plays scenarios on `sitl` and prints {name: passed} as JSON: the inner half of a mutation run.

A mutant that crashes or hangs its rig has not passed.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rover.errors import PreflightFailed, RoverError

from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play
from rover_hil.serve import share_one_core


def main(files: list[str]) -> int:
    """Returns the exit code."""
    share_one_core()
    passed: dict[str, bool] = {}
    for file in files:
        scenario = load_scenario(Path(file))
        try:
            passed[Path(file).stem] = play(scenario, "sitl").passed
        except PreflightFailed:
            raise
        except RoverError:
            passed[Path(file).stem] = False
    print(json.dumps(passed))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
