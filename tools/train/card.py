"""The model card: what the classifier was trained on, what it is for, and what it measures on what it never saw."""

from __future__ import annotations

import argparse

import numpy as np
from rover.detection.patch import LENGTH, SIDE, STATISTICS
from rover.detection.picture_patch import NUMBERS

from tools.train.measure import as_markdown


def card(
    counts: dict[str, int],
    results: dict[str, tuple[np.ndarray, np.ndarray]],
    driven: dict[str, str],
    notes: dict[str, str],
    sha256: str,
    options: argparse.Namespace,
) -> str:
    """Markdown. counts: samples per class. driven: per drive its tables. notes: of the calibration.

    results: per test set labels (N,) and probabilities (N, classes).
    """
    told = ", ".join(f"{number} {name}" for name, number in counts.items())
    real = (
        "Real pictures: Tenorio-Tamayo et al., Data in Brief 49:109443 (CC BY 4.0), 8-bit and not radiometric, as\n"
        "they lie on disk and altered (turned, other contrast, smooth discs laid on the ground as casings). All\n"
        "zones are learned from; docs/detection.md tells what networks say of zones and sessions that they never saw."
        if options.data is not None
        else "No real pictures were used."
    )
    shown = " --data DIR" if options.data is not None else ""
    stages = f"First {options.fields} fields alone, then {options.again} of them and the pictures together."
    if options.start is not None:
        shown += f" --start MODEL --again {options.again} --epochs {options.epochs}"
        stages = (
            f"In place of the first stage it goes on from a model that had learned from fields alone, then from\n"
            f"{options.again} fields and the pictures together; `make train` does both stages from a seed."
        )
    calibration = ", ".join(f"{name} {value}" for name, value in notes.items())
    sections = "\n\n".join(f"### {name}\n\n{as_markdown(labels, p)}" for name, (labels, p) in results.items())
    drives = "\n\n".join(f"### {name}\n\n{table}" for name, table in driven.items())
    return f"""# landmine_mlp.onnx

A multilayer perceptron with 256 and 128 hidden units (paper section 3.2.1) that tells obstacles, surface mines, buried
mines and background apart. Input: {LENGTH} numbers per candidate: a {SIDE}x{SIDE} thermal patch, a {SIDE}x{SIDE}
occupancy patch, a {SIDE}x{SIDE} wide patch, {len(STATISTICS)} statistics in kelvin and metres
(`rover.detection.patch`), {NUMBERS} numbers of pictures that know neither (`rover.detection.picture_patch`), and which
of the two it is. Output: probabilities, calibrated for each kind ({calibration}).

SHA-256: `{sha256}`

## Training

`python -m tools.train --fields {options.fields} --frames {options.frames} --seed {options.seed}{shown}`.
{stages}
{sum(counts.values())} candidates in the last stage: {told}.
Synthetic fields in loam (more than half), dry sand and moist clay, most of them by day and many full of pebbles,
rendered with the plant's camera (50 mK noise, fixed pattern, vignetting, parallax) from random poses, and cut out by
the same code that runs on the rover. Six in ten buried mines lie 4 to 7 cm deep. Nothing is learned from mines weaker
than 0.25 K at the surface; the tests count them as mines.
{real}

## Measured on what was never trained on

Counts are candidates of single frames; the rover fuses several frames of a place (`rover.detection.fusion`).

{sections}

## Driven over whole fields

`python -m tools.bench detector`: several looks fused into places, as on the rover, with poses good to 1 cm. Mines
without contrast count as missed.

{drives}

## Limits

Trained on simulated heat, one camera geometry (0.75 m mast, 52 degrees down) and two kinds of obstacles. Around the
two daily zero crossings mines have no contrast and cannot be seen. An indication is a reason to look closer, and the
absence of one is no statement about the ground.
"""
