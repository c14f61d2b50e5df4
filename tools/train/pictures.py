"""`python -m tools.train pictures`: the network for pictures that know neither kelvin nor metres, from real pictures.

All pictures are learned from; what such networks say of pictures never seen is measured by `python -m tools.evaluate`.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rover.detection.classifier import PICTURES, default_model

from tools.train import measure
from tools.train.card import write_section
from tools.train.export import fold, write
from tools.train.network import fit
from tools.train.picture_card import picture_section
from tools.train.picture_recipe import picture_samples, picture_set
from tools.train.picture_samples import BACKGROUND, BURIED, CANDIDATE, SURFACE, PictureSamples
from tools.train.records import Record, read_records

# Zones that the calibration is read from: a network that has not seen them judges them.
CALIBRATION_ZONES = ("3", "5")
CALIBRATION_EPOCHS = 3


def main(arguments: Sequence[str]) -> None:
    """Trains, calibrates, writes."""
    parser = argparse.ArgumentParser(prog="python -m tools.train pictures", description=__doc__)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--epochs", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--out", type=Path, default=Path(default_model(PICTURES)))
    options = parser.parse_args(arguments)
    if options.data is None:
        parser.error("--data DIR (or ROVER_DATA) must name the folder that holds landmines/index.csv")
    begun = time.monotonic()
    records = read_records(options.data)
    real = picture_samples(records, options.seed, options.cache)
    print(f"{len(real)} samples after {time.monotonic() - begun:.0f} s", flush=True)
    network = fit(*picture_set(real, np.ones(len(real), bool), options.seed), options.epochs, options.seed)
    factor, shift = calibrate(real, records, options.seed)
    layers = fold(network.weights, network.biases, network.mean, network.scale, factor, shift[list(network.classes)])
    notes = {"seed": str(options.seed), "factor": f"{factor:.4f}", "offset": f"{shift[BACKGROUND]:.4f}"}
    sha256 = write(options.out, PICTURES, network.every_class(layers), notes)
    write_section(options.out.parent / "README.md", options.out.name, picture_section(len(records), notes, sha256))
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")


def calibrate(real: PictureSamples, records: list[Record], seed: int) -> tuple[float, np.ndarray]:
    """Factor and offsets for the logits, as a network of its own that never saw these zones needs them."""
    zone = np.array([record.zone for record in records])[real.picture]
    held_out = np.isin(zone, CALIBRATION_ZONES)
    network = fit(*picture_set(real, ~held_out, seed), CALIBRATION_EPOCHS, seed)
    judged = held_out & (real.round == 0) & (real.what == CANDIDATE)
    judged &= np.isin(real.truth, (SURFACE, BURIED, BACKGROUND))
    logits = network.logits(real.vectors[judged].astype(np.float32))
    return measure.fit_pictures(real.truth[judged].astype(np.int64), logits, BACKGROUND)
