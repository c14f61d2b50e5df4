"""Plots the ground of a mission, or prints the daily contrast curves.

python -m rover_hil.ground --mission mission.toml --seed 3 --out field.png
python -m rover_hil.ground --contrasts loam
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from rover.errors import BadInput, RoverError

from rover_hil.ground.field import Ground, build
from rover_hil.ground.signature import contrast_table


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m rover_hil.ground", description=__doc__.splitlines()[0])
    parser.add_argument("--mission", type=Path, help="mission file (TOML)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--data", type=Path, help="folder that holds landmines/: lay real texture")
    parser.add_argument("--out", type=Path, help="the plot, PNG or SVG by its ending")
    parser.add_argument("--no-marks", action="store_true", help="temperature only")
    parser.add_argument("--contrasts", metavar="SOIL", help="print the daily contrasts of mines in SOIL")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    options = _arguments(argv)
    try:
        if options.contrasts:
            print(contrast_table(options.contrasts))
            return 0
        if options.mission is None or options.out is None:
            raise BadInput("give --mission FILE and --out PLOT, or --contrasts SOIL")
        from rover.mission.config import load

        ground = build(load(options.mission), options.seed, options.data)
        _plot(ground, options.out, not options.no_marks)
        print(json.dumps(ground.truth(), indent=1))
    except RoverError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def _plot(ground: Ground, out: Path, marks: bool) -> None:
    try:
        from rover_hil.figure_file import write_figure
        from rover_hil.ground.plot import figure
    except ImportError as error:
        raise BadInput(f"--out {out}: a plot needs {error.name}: make setup-dev installs it") from error
    write_figure(figure(ground, marks), out)


if __name__ == "__main__":
    raise SystemExit(main())
