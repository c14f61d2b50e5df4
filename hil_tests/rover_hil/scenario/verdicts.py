"""Plays scenarios and prints {name: passed} as JSON: the inner half of a mutation run.

python -m rover_hil.scenario.verdicts --rig sitl FILE ...

A mutant that crashes or hangs its rig has not passed.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from rover.errors import PreflightFailed, RoverError

from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play
from rover_hil.serve import share_one_core


def main(argv: list[str]) -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rig", default="sitl", choices=("sitl", "emulator"))
    parser.add_argument("file", nargs="+", type=Path)
    given = parser.parse_args(argv)
    share_one_core()
    passed: dict[str, bool] = {}
    for file in given.file:
        scenario = load_scenario(file)
        try:
            passed[file.stem] = play(scenario, given.rig).passed
        except PreflightFailed:
            raise
        except RoverError:
            passed[file.stem] = False
    print(json.dumps(passed))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
