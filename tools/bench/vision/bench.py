"""Runs the tables one after the other."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import cv2
from rover_hil.figure_file import write_figure

from tools.bench.vision import facade, methods, pairs, plot, preparation, registration, speed, tables, wall

SIMULATED = ("drives", "loops", "speed")
REAL = ("registration", "facade", "wall", "unrelated", "pairs", "clusters", "preparation", "methods")


def main(arguments: list[str]) -> int:
    """Prints the tables asked for as Markdown."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench vision", description=__doc__)
    parser.add_argument("--only", choices=SIMULATED + REAL, action="append", help="this table alone; may be repeated")
    parser.add_argument("--camera", default="lepton-160", help="of the drives and loops")
    parser.add_argument("--seeds", type=int, default=8, help="drives")
    parser.add_argument("--first", type=int, default=7000, help="seed of the first field")
    parser.add_argument("--metres", type=float, default=20.0)
    parser.add_argument("--slip", type=float, default=0.05, help="bound of each wheel's scale error")
    parser.add_argument("--loops", type=int, default=10)
    parser.add_argument("--kidnaps", type=int, default=10, help="at the end of each drive")
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--pairs", type=int, default=550, help="unrelated pairs")
    parser.add_argument("--sheets", type=Path, metavar="DIR", help="pairs: pictures of what was registered, to look at")
    parser.add_argument("--peers", default=os.environ.get("ROVER_OPENCV4", ""), metavar="PYTHON",
                        help="methods: a Python with NumPy and OpenCV 4, whose AKAZE OpenCV 5 has no more")  # fmt: skip
    parser.add_argument("--warp-seed", type=int, default=2201, help="methods: of the synthetic pairs")
    parser.add_argument("--warps", type=int, default=42, help="methods: synthetic pairs of each kind")
    parser.add_argument("--plot", type=Path, help="PNG or SVG: the plot of docs/reference/vision.md, nothing else")
    options = parser.parse_args(arguments)
    wanted = options.only or list(SIMULATED + REAL)
    cv2.setNumThreads(1)
    if options.plot is not None:
        write_figure(plot.figure(options.camera, options.first), options.plot)
        return 0
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    if "drives" in wanted:
        print(f"{options.seeds} simulated drives of {options.metres:g} m, {options.slip:.0%} slip, {options.camera}:\n")
        print(tables.drive_table(options.camera, options.seeds, options.first, options.slip, options.metres,
                                 options.kidnaps) + "\n")  # fmt: skip
    if "loops" in wanted:
        print(f"{options.loops} simulated loops, wheels and frames, cm RMS loop by loop:\n")
        print(tables.loop_table(options.camera, 3, options.first + 500, options.slip, options.loops) + "\n")
    if "speed" in wanted:
        busy = f" (the machine is busy, load {load:.1f} per core: too long)" if load > 0.7 else ""
        print(f"One frame from counts to pose, ms of processor time, median{busy}:\n")
        print(speed.speed_table(options.first, 6.0) + "\n")
    if set(wanted) & set(REAL):
        if options.data is None:
            print("no real pictures: give --data DIR or ROVER_DATA", file=sys.stderr)
            return 0 if options.only is None else 2
        _real(wanted, Path(options.data), options.pairs, options.sheets)
        if "methods" in wanted:
            print(methods.methods_table(Path(options.data), options.peers, options.warp_seed, options.warps) + "\n")
    return 0


def _real(wanted: list[str], data: Path, unrelated: int, sheets: Path | None) -> None:
    if "registration" in wanted:
        print(registration.graf_table(data) + "\n")
    if "facade" in wanted:
        print(facade.facade_table(data) + "\n")
    if "wall" in wanted:
        print(wall.wall_table(data) + "\n")
    if "clusters" in wanted:
        print(registration.cluster_table(data) + "\n")
    if "unrelated" in wanted:
        print(registration.unrelated_table(data, unrelated, 1) + "\n")
    if "pairs" in wanted:
        print(pairs.pairs_table(data, sheets) + "\n")
    if "preparation" in wanted:
        print(preparation.preparation_table(data) + "\n")
