"""Peers of the planner: a C++ program with grid A* and OMPL, and the RRT of PythonRobotics' kind written anew here."""

from __future__ import annotations

import math
import random
import shutil
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tools.bench.planner.scenes import Point

# (milliseconds, metres, nodes) of one run
Run = tuple[float, float, float]
SOURCE = Path(__file__).with_name("peers.cpp")
OMPL_HEADERS = (Path("/usr/include/ompl-1.5"), Path("/usr/include/ompl"), Path("/usr/local/include/ompl"))


# How the stops of a task are visited; pairs: every two stops are a task of their own.
GIVEN, ANY, PAIRS = 0, 1, 2


def build(folder: Path) -> tuple[Path | None, str]:
    """The compiled C++ peers and a line that says what is in them; none without a compiler."""
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        return None, "no C++ compiler: A* and OMPL are left out"
    program = folder / "peers"
    command = [compiler, "-O2", "-std=c++17", str(SOURCE), "-o", str(program)]
    headers = next((path for path in OMPL_HEADERS if path.exists()), None)
    if headers is not None:
        extra = ["-DWITH_OMPL", "-I/usr/include/eigen3", f"-I{headers}", "-lompl"]
        if subprocess.run([*command, *extra], capture_output=True, check=False).returncode == 0:
            return program, "grid A* and OMPL, both C++ with -O2, the collision check compiled in"
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode != 0:
        return None, "the C++ peers do not compile here: A* and OMPL are left out"
    return program, "grid A* in C++ with -O2; OMPL is not installed here (Debian: libompl-dev) and left out"


def run(
    program: Path,
    blocked: NDArray[np.bool_],
    resolution: float,
    radius: float,
    circles: Sequence[Sequence[float]],
    stops: Sequence[Point],
    *,
    order: int = GIVEN,
    ompl_seeds: int = 0,
    leg_ms: float = 20.0,
) -> dict[str, list[Run]]:
    """Runs of every peer on one task, by method."""
    rows, columns = blocked.shape
    cells = "".join("1" if cell else "0" for cell in blocked.ravel())
    lines = [f"{columns} {rows} {resolution} {radius}", cells, str(len(circles))]
    lines += [" ".join(repr(float(v)) for v in circle) for circle in circles]
    lines += [str(len(stops)), *(f"{x!r} {y!r}" for x, y in stops), f"{order} {ompl_seeds} {leg_ms}"]
    answer = subprocess.run([str(program)], input="\n".join(lines), capture_output=True, text=True, check=True)
    found: dict[str, list[Run]] = defaultdict(list)
    for line in answer.stdout.splitlines():
        method, _, ms, metres, nodes = line.split()
        found[method].append((float(ms), float(metres), float(nodes)))
    return dict(found)


def scratch() -> tempfile.TemporaryDirectory[str]:
    """A folder for the compiled program."""
    return tempfile.TemporaryDirectory(prefix="planner-bench-")


def python_rrt(
    size: tuple[float, float],
    circles: Sequence[Sequence[float]],
    stops: Sequence[Point],
    radius: float,
    seed: int,
    *,
    star: bool = False,
    step: float = 0.3,
    goal_share: float = 0.05,
) -> Run:
    """RRT or RRT* goal by goal as a textbook in plain Python has it: lists, linear search, sampled edges."""
    rng = random.Random(seed)
    begin = time.thread_time()
    total, nodes = 0.0, 0
    for start, goal in pairwise(stops):
        points, parents, costs = [start], [-1], [0.0]
        while True:
            sample = goal if rng.random() < goal_share else (rng.uniform(0, size[0]), rng.uniform(0, size[1]))
            nearest = min(range(len(points)), key=lambda i: math.dist(points[i], sample))
            away = math.dist(points[nearest], sample)
            if away == 0.0:
                continue
            part = min(1.0, step / away)
            new = _towards(points[nearest], sample, part)
            if not _clear(size, circles, points[nearest], new, radius):
                continue
            parent = nearest
            near = [i for i, p in enumerate(points) if star and math.dist(p, new) <= 2.0 * step]
            for i in near:
                through = costs[i] + math.dist(points[i], new)
                known = costs[parent] + math.dist(points[parent], new)
                if through < known and _clear(size, circles, points[i], new, radius):
                    parent = i
            points.append(new)
            parents.append(parent)
            costs.append(costs[parent] + math.dist(points[parent], new))
            for i in near:
                through = costs[-1] + math.dist(points[i], new)
                if through < costs[i] and _clear(size, circles, new, points[i], radius):
                    parents[i], costs[i] = len(points) - 1, through
            if math.dist(new, goal) <= step and _clear(size, circles, new, goal, radius):
                break
        at, total = len(points) - 1, total + math.dist(points[-1], goal)
        while parents[at] != -1:
            total += math.dist(points[at], points[parents[at]])
            at = parents[at]
        nodes += len(points) + 1
    return (time.thread_time() - begin) * 1e3, total, nodes


def _towards(a: Point, b: Point, share: float) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def _clear(size: Point, circles: Sequence[Sequence[float]], a: Point, b: Point, radius: float) -> bool:
    count = max(2, math.ceil(math.dist(a, b) / 0.02))
    for i in range(count + 1):
        x, y = _towards(a, b, i / count)
        if not (radius <= x <= size[0] - radius and radius <= y <= size[1] - radius):
            return False
        if any((x - cx) ** 2 + (y - cy) ** 2 < (radius + r) ** 2 for cx, cy, r in circles):
            return False
    return True
