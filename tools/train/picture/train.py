"""`python -m tools.train pictures`: the network for pictures that know neither kelvin nor metres, from real pictures.

All pictures are learned from. Calibration and threshold come from networks that never saw the zones that they judge;
what such networks say fold by fold is measured by `python -m tools.evaluate`.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rover.detection.classifier import PICTURES, default_model

from tools.train.card import write_section
from tools.train.export import fold, write
from tools.train.measure import calibration_error, fit_pictures
from tools.train.picture.calibration import Calibration
from tools.train.picture.card import picture_section
from tools.train.picture.hits import loudness, threshold_for
from tools.train.picture.recipe import learn, mirrored_logits, mirrored_mean, picture_samples
from tools.train.picture.records import Record, read_records
from tools.train.picture.samples import BACKGROUND, BURIED, CANDIDATE, SURFACE, PictureSamples

# Zones that are held out together for calibration and threshold: a network that has not seen them judges them.
HELD_OUT = (("3", "5"), ("4", "7"), ("1", "6", "9"))
# The probability of detection that the threshold is chosen for, on pictures of zones never seen.
STATED_PD = 0.9


def main(arguments: Sequence[str]) -> None:
    """Trains, calibrates, writes."""
    parser = argparse.ArgumentParser(prog="python -m tools.train pictures", description=__doc__)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--out", type=Path, default=Path(default_model(PICTURES)))
    options = parser.parse_args(arguments)
    if options.data is None:
        parser.error("--data DIR (or ROVER_DATA) must name the folder that holds landmines/index.csv")
    begun = time.monotonic()
    records = read_records(Path(options.data))
    samples = picture_samples(records, options.seed, options.cache)
    print(f"{len(samples)} samples after {time.monotonic() - begun:.0f} s", flush=True)
    network = learn(samples, np.ones(len(samples), bool), options.seed).network
    print(f"trained after {time.monotonic() - begun:.0f} s", flush=True)
    known = calibrate(samples, records, options.seed)
    layers = fold(network.weights, network.biases, network.mean, network.scale, known.factor, known.offsets)
    notes = {
        "seed": str(options.seed),
        "factor": f"{known.factor:.4f}",
        "offset": f"{known.offsets[-1]:.4f}",
        "threshold": f"{known.threshold:.4f}",
    }
    sha256 = write(options.out, PICTURES, network.every_class(layers), notes)
    text = picture_section(len(records), notes, known, sha256)
    write_section(options.out.parent / "README.md", options.out.name, text)
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")


def calibrate(samples: PictureSamples, records: Sequence[Record], seed: int) -> Calibration:
    """Of the logits of surface, buried and background, from networks that never saw the zones that they judge."""
    zone = np.array([record.zone for record in records])[samples.picture]
    rows, logits = [], []
    for zones in HELD_OUT:
        held_out = np.isin(zone, zones)
        network = learn(samples, ~held_out, seed).network
        rows.append(np.nonzero(held_out & (samples.round == 0) & (samples.what == CANDIDATE))[0])
        logits.append(mirrored_logits(network, samples.vectors[rows[-1]]))
        print(f"zones {', '.join(zones)} judged by a network that never saw them", flush=True)
    chosen, answers = np.concatenate(rows), np.concatenate(logits, axis=1)
    truth = samples.truth[chosen].astype(np.int64)
    told = np.isin(truth, (SURFACE, BURIED, BACKGROUND))
    labels = truth[told] - SURFACE
    factor, offsets = fit_pictures(labels, answers[:, told].mean(axis=0), BACKGROUND - SURFACE)
    p = mirrored_mean(answers * factor + offsets)
    likely = p[told][:, :-1].sum(axis=1) >= 0.1
    mines, false, pictures = loudness(samples, chosen, 1.0 - p[:, -1], records)
    threshold = float(np.floor(1e4 * threshold_for(STATED_PD, mines)) / 1e4)
    return Calibration(
        factor,
        offsets,
        calibration_error(labels[likely], p[told][likely]),
        threshold,
        int((mines >= threshold).sum()),
        len(mines),
        int((false >= threshold).sum()),
        pictures,
    )
