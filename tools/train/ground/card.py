"""The ground network's part of the model card: what it learned from, and what it measures on what it never saw."""

from __future__ import annotations

import argparse

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.detection.ground.patch import LENGTH, SIDE, STATISTICS

from tools.train.ground.fields import HELD_OUT_HOURS
from tools.train.ground.samples import Looks
from tools.train.measure import by_contrast, looks_as_markdown


def ground_section(
    counts: dict[str, int],
    results: dict[str, tuple[Looks, NDArray[np.float32]]],
    floor: float,
    driven: dict[str, tuple[str, str]],
    notes: dict[str, str],
    sha256: str,
    options: argparse.Namespace,
) -> str:
    """Markdown. counts: samples per class. driven: per drive the measurement of tools.bench and its tables.

    notes: of the calibration. results: per test set its looks and probabilities (N, classes); mines below `floor`
    kelvin do not count there.
    """
    told = ", ".join(f"{number} {name}" for name, number in counts.items())
    calibration = ", ".join(f"{name} {value}" for name, value in notes.items())
    sections = "\n\n".join(
        f"#### {name}\n\n{looks_as_markdown(looks, p, floor)}\n\n{by_contrast(looks, p)}"
        for name, (looks, p) in results.items()
    )
    hours = ", ".join(f"{begin:g} to {end:g}" for begin, end in HELD_OUT_HOURS)
    drives = "\n\n".join(
        f"#### {name}\n\n<!-- results: .venv/bin/python -m tools.bench {bench} -->\n\n{tables}\n\n<!-- /results -->"
        for name, (bench, tables) in driven.items()
    )
    return f"""Input: {LENGTH} numbers per candidate: a {SIDE}x{SIDE} thermal patch, a {SIDE}x{SIDE} occupancy patch, a
{SIDE}x{SIDE} wide patch and {len(STATISTICS)} statistics in kelvin and metres (`rover.detection.ground.patch`). Output:
calibrated probabilities ({calibration}).

SHA-256: `{sha256}`

### Training

`.venv/bin/python -m tools.train ground --fields {options.fields} --frames {options.frames} --seed {options.seed}`,
OpenCV {cv2.__version__}.
{sum(counts.values())} candidates: {told}.
Synthetic fields in loam (more than half), dry sand and moist clay, most of them by day and many full of pebbles,
rendered with the plant's camera (50 mK noise, fixed pattern, vignetting, parallax) from random poses, and cut out by
the same code that runs on the rover. A quarter of the mines stand on the ground, more than half of the buried ones
lie 3 to 7 cm deep. Nothing is learned from the hours {hours},
nor from mines weaker than 0.25 K at the surface.
In each epoch the pictures of ground and of buried mines are turned by chance, those of all else mirrored.

### Measured on what was never trained on

Single looks; the rover fuses many of them (`rover.detection.fusion`). A mine of at least {floor:g} K at the surface
counts once for every look that it is in view of, also where no candidate lies on it; obstacles and ground count by
candidates. 95 % intervals: fields drawn again.

{sections}

### Driven over whole fields

Several looks fused into places, as on the rover, with poses good to 1 cm. Mines without contrast count as missed.

{drives}

### Limits

Ground rougher than 0.12 K at the narrowest scale is toned down to that before it is judged
(`rover.detection.ground.detect`): the simulated soil is smoother than real ground, where false
indications are many more.
Trained on simulated heat, one camera geometry (0.75 m mast, 52 degrees down) and two kinds of obstacles. Around the
two daily zero crossings mines have no contrast and cannot be seen. An indication is a reason to look closer, and the
absence of one is no statement about the ground."""
