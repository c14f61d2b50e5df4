"""`python -m tools.train [--data DIR]`: trains the classifier and writes it with its model card.

First on synthetic fields alone, then on a part of them and the real pictures together.

The synthetic numbers in the card come from what was never trained on: other seeds, one whole soil. Of the real
pictures all are learned from; what they say of pictures never seen is measured by `python -m tools.evaluate`.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import time
import warnings
from pathlib import Path

import numpy as np
from rover.detection.classifier import CLASSES, Classifier, default_model
from rover.vision.camera_file import load_camera
from sklearn.exceptions import ConvergenceWarning

from tools.bench import detector
from tools.train import measure
from tools.train.card import card
from tools.train.export import fold, read, write
from tools.train.network import fit
from tools.train.picture_samples import BACKGROUND, BURIED, CANDIDATE, SURFACE, PictureSamples
from tools.train.recipe import field_samples, joint_set, picture_samples, picture_set
from tools.train.records import Record, read_records
from tools.train.samples import Samples, mirrored

TRAINED_SOILS = ("loam", "dry-sand", "moist-clay")
HELD_OUT_SOIL = ("clay",)
# Zones that the calibration of pictures is read from: a network that has not seen them judges them.
CALIBRATION_ZONES = ("3", "5")
CALIBRATION_EPOCHS = 3
FIRST_CALIBRATION, FIRST_TEST, FIRST_SOIL_TEST = 50_000, 60_000, 70_000
TEST_FIELDS = 24
LEAST_LEARNED, LEAST_TESTED = 0.25, 0.5
# Fields that are driven over for the card.
FIRST_DRIVE = 4000


def main() -> None:
    """Trains, writes, measures what was written."""
    parser = argparse.ArgumentParser(prog="python -m tools.train", description=__doc__)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--fields", type=int, default=360, help="synthetic fields to learn from")
    parser.add_argument("--frames", type=int, default=20, help="frames per field")
    parser.add_argument("--start", type=Path, help="a model to go on from in place of the first stage")
    parser.add_argument("--first-epochs", type=int, default=8, help="on fields alone")
    parser.add_argument("--epochs", type=int, default=4, help="on fields and pictures together")
    parser.add_argument("--again", type=int, default=360, help="fields that are learned from in both stages")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drives", type=int, default=20, help="fields that are driven over for the card")
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--out", type=Path, default=Path(default_model()))
    options = parser.parse_args()
    warnings.simplefilter("ignore", ConvergenceWarning)
    begun = time.monotonic()
    camera = load_camera("lepton-160")

    def fields(soils: tuple[str, ...], first: int, count: int, weakest: float) -> Samples:
        return field_samples(camera, soils, range(first, first + count), options.frames, weakest, options.cache)

    start = read(options.start) if options.start else None
    if start is None:
        train = both_ways(fields(TRAINED_SOILS, 0, options.fields, LEAST_LEARNED))
        start = fit(*joint_set(train, None), options.first_epochs, options.seed)
        print(f"fields alone after {time.monotonic() - begun:.0f} s", flush=True)
    train = both_ways(fields(TRAINED_SOILS, 0, min(options.again, options.fields), LEAST_LEARNED))
    calibrate = fields(TRAINED_SOILS, FIRST_CALIBRATION, TEST_FIELDS, LEAST_LEARNED)
    tests = {
        "synthetic, trained soils, other seeds": fields(TRAINED_SOILS, FIRST_TEST, TEST_FIELDS, LEAST_TESTED),
        "synthetic, held-out soil clay": fields(HELD_OUT_SOIL, FIRST_SOIL_TEST, TEST_FIELDS, LEAST_TESTED),
    }
    pictures, real = None, None
    if options.data is not None:
        records = read_records(Path(options.data))
        real = picture_samples(records, options.seed, options.cache)
        pictures = picture_set(real, np.ones(len(real), bool), options.seed)
    vectors, labels, weights = joint_set(train, pictures)
    print(f"{len(labels)} samples, {train.counts()} of fields, after {time.monotonic() - begun:.0f} s", flush=True)

    network = fit(vectors, labels, weights, options.epochs, options.seed, start)
    temperature = measure.fit_temperature(calibrate.labels, network.logits(calibrate.vectors))
    layers = fold(network.weights, network.biases, network.mean, network.scale, temperature)
    notes = {"seed": str(options.seed), "temperature": f"{temperature:.4f}"}
    scale = None
    if real is not None:
        factor, shift = calibrate_pictures(real, records, options.seed)
        # The file's logits are already divided by the temperature.
        scale = (factor * temperature, shift)
        notes |= {"picture_factor": f"{factor:.4f}", "picture_offset": f"{shift[BACKGROUND]:.4f}"}
    write(options.out, layers, notes, scale)
    print(f"trained after {time.monotonic() - begun:.0f} s", flush=True)

    classifier = Classifier(options.out)
    results = {name: (s.labels, classifier.predict(s.vectors.astype(np.float32))) for name, s in tests.items()}
    drives = {
        f"the demo mission, fields {FIRST_DRIVE} and on": False,
        f"other soils and hours, fields {FIRST_DRIVE} and on (--mixed)": True,
    }
    driven = {
        name: detector.as_markdown(detector.drive_all(options.out, options.drives, FIRST_DRIVE, mixed))
        for name, mixed in drives.items()
        if options.drives
    }
    counts = {name: int((labels == i).sum()) for i, name in enumerate(CLASSES)}
    text = card(counts, results, driven, notes, hashlib.sha256(options.out.read_bytes()).hexdigest(), options)
    (options.out.parent / "README.md").write_text(text, encoding="utf-8")
    for name, (truth, p) in results.items():
        print(f"\n{name}\n{measure.as_markdown(truth, p)}")
    print(f"\n{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")


def both_ways(samples: Samples) -> Samples:
    """Samples and their mirror images."""
    return Samples.join([samples, mirrored(samples)])


def calibrate_pictures(real: PictureSamples, records: list[Record], seed: int) -> tuple[float, np.ndarray]:
    """Factor and offsets for the logits of pictures, as a network of its own that never saw these zones needs them."""
    zone = np.array([record.zone for record in records])[real.picture]
    held_out = np.isin(zone, CALIBRATION_ZONES)
    network = fit(*picture_set(real, ~held_out, seed), CALIBRATION_EPOCHS, seed)
    judged = held_out & (real.round == 0) & (real.what == CANDIDATE)
    judged &= np.isin(real.truth, (SURFACE, BURIED, BACKGROUND))
    logits = network.logits(real.vectors[judged].astype(np.float32))
    return measure.fit_pictures(real.truth[judged].astype(np.int64), logits, BACKGROUND)


if __name__ == "__main__":
    main()
