"""The simulated world goes on where a former run has left it: where the rover stands, and what its camera has seen."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.archive_file import read_archive, write_archive
from rover.errors import BadInput
from rover.record.tum import read_tum
from rover_plant import Plant

SEEN = "truth_seen.npz"
WHAT = "record of the ground that was seen"


def save_seen(out: Path, seen: NDArray[np.bool_]) -> None:
    """Ground that the camera has shown by the referee's account, bool (rows, columns) of 1 cm. Raises BadInput."""
    write_archive(out / SEEN, WHAT, {"seen": seen})


def drive_on(plant: Plant, former: Path, seed: int) -> None:
    """Sets the rover where it stood at the end of the run in `former`.

    Raises BadInput for a run on a real rover, with another seed or another area, and for files that are damaged.
    """
    truth = former / "truth.json"
    try:
        driven = json.loads(truth.read_text(encoding="utf-8"))["seed"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{truth}: not there, or damaged: only a simulated run is gone on from on this rig") from error
    if driven != seed:
        raise BadInput(f"{former}: driven with --seed {driven}, a field other than that of --seed {seed}")
    poses = read_tum(former / "truth.tum")
    seen = read_archive(former / SEEN, WHAT).get("seen")
    try:
        if seen is None or not len(poses):
            raise ValueError("nothing there")
        _, x, y, heading = poses[-1].tolist()
        plant.drive_on(np.ascontiguousarray(seen, dtype=bool), x, y, heading)
    except ValueError as error:
        raise BadInput(f"{former}: its truth does not fit this mission: {error}") from error
