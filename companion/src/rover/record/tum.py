"""The TUM text format of trajectories: one pose a line, read by evo and its kin."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.plain_file import plain_file

TUM_HEADER = "# timestamp tx ty tz qx qy qz qw\n"


def tum_lines(poses: NDArray[np.float64]) -> str:
    """Poses (N, 4) of time, x, y, heading as TUM text: seconds, metres, a unit quaternion; z is 0."""
    lines = [TUM_HEADER]
    for time, x, y, heading in np.asarray(poses, dtype=np.float64).reshape(-1, 4).tolist():
        qz, qw = math.sin(0.5 * heading), math.cos(0.5 * heading)
        lines.append(f"{time:.6f} {x:.6f} {y:.6f} 0.000000 0.000000 0.000000 {qz:.9f} {qw:.9f}\n")
    return "".join(lines)


def write_tum(path: Path, poses: NDArray[np.float64]) -> None:
    """Writes poses (N, 4) of time, x, y, heading."""
    path.write_text(tum_lines(poses), encoding="ascii")


def read_tum(path: Path) -> NDArray[np.float64]:
    """Poses (N, 4) of time, x, y, heading (the yaw). Raises BadInput naming the line that is wrong."""
    poses = []
    try:
        text = plain_file(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot read the trajectory: {error}") from error
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            time, x, y, _, qx, qy, qz, qw = (float(word) for word in line.split())
        except ValueError as error:
            raise BadInput(f"{path}:{number}: expected 8 numbers (timestamp tx ty tz qx qy qz qw)") from error
        heading = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        poses.append((time, x, y, heading))
    return np.array(poses, dtype=np.float64).reshape(-1, 4)
