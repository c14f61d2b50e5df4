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
from rover.detection.picture.features import shipped_features

from tools.train.card import write_section
from tools.train.export import fold, write
from tools.train.measure import calibration_error, fit_pictures, softmax
from tools.train.picture.calibration import Calibration
from tools.train.picture.card import picture_section
from tools.train.picture.flights import flights
from tools.train.picture.hits import loudness
from tools.train.picture.recipe import learn, logits, picture_samples
from tools.train.picture.records import Record, read_records
from tools.train.picture.samples import BACKGROUND, BURIED, CANDIDATE, SURFACE, PictureSamples

# Zones that are held out together for calibration and threshold: a network that has not seen them judges them.
HELD_OUT = (("1", "6"), ("3",), ("4",), ("5",), ("7",), ("9",))
# False alarms a picture that the threshold is chosen for, on pictures of zones never seen.
STATED_ALARMS = 0.15


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
        "features": shipped_features().sha256,
    }
    sha256 = write(options.out, PICTURES, network.every_class(layers), notes)
    text = picture_section(len(records), notes, known, len(HELD_OUT), STATED_ALARMS, sha256)
    write_section(options.out.parent / "README.md", options.out.name, text)
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")


def calibrate(samples: PictureSamples, records: Sequence[Record], seed: int) -> Calibration:
    """Of the logits of surface, buried and background, from networks that never saw the zones that they judge."""
    zone = np.array([record.zone for record in records])[samples.picture]
    rows, found = [], []
    for zones in HELD_OUT:
        held_out = np.isin(zone, zones)
        network = learn(samples, ~held_out, seed).network
        rows.append(np.nonzero(held_out & (samples.round == 0) & (samples.what == CANDIDATE))[0])
        found.append(logits(network, samples.vectors[rows[-1]]))
        print(f"zones {', '.join(zones)} judged by a network that never saw them", flush=True)
    chosen, answers = np.concatenate(rows), np.concatenate(found)
    truth = samples.truth[chosen].astype(np.int64)
    told = np.isin(truth, (SURFACE, BURIED, BACKGROUND))
    labels = truth[told] - SURFACE
    factor, offsets = fit_pictures(labels, answers[told], BACKGROUND - SURFACE)
    p = softmax(answers * factor + offsets)
    likely = p[told][:, :-1].sum(axis=1) >= 0.1
    judged = loudness(samples, chosen, 1.0 - p[:, -1], records)
    threshold = float(np.ceil(1e4 * judged.threshold_for(STATED_ALARMS)) / 1e4)
    pd, false_alarms = judged.at(threshold, flights(records))
    return Calibration(
        factor,
        offsets,
        calibration_error(labels[likely], p[told][likely]),
        threshold,
        pd,
        false_alarms,
        len(judged.mines),
        len(judged.pictures),
    )
