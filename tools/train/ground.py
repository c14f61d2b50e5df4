"""`python -m tools.train ground`: the network for candidates in kelvin and metres, from synthetic fields.

The numbers in the card come from what was never trained on: other seeds, one whole soil.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rover.detection.classifier import CLASSES, GROUND, Classifier, default_model
from rover.vision.camera_file import load_camera

from tools.bench import detector
from tools.train import measure
from tools.train.card import write_section
from tools.train.export import fold, write
from tools.train.ground_card import ground_section
from tools.train.network import fit
from tools.train.recipe import field_samples
from tools.train.samples import Samples, mirrored

TRAINED_SOILS = ("loam", "dry-sand", "moist-clay")
HELD_OUT_SOIL = ("clay",)
FIRST_CALIBRATION, FIRST_TEST, FIRST_SOIL_TEST = 50_000, 60_000, 70_000
TEST_FIELDS = 24
LEAST_LEARNED, LEAST_TESTED = 0.25, 0.5
# Fields that are driven over for the card.
FIRST_DRIVE = 4000


def main(arguments: Sequence[str]) -> None:
    """Trains, writes, measures what was written."""
    parser = argparse.ArgumentParser(prog="python -m tools.train ground", description=__doc__)
    parser.add_argument("--fields", type=int, default=360, help="synthetic fields to learn from")
    parser.add_argument("--frames", type=int, default=20, help="frames per field")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drives", type=int, default=20, help="fields that are driven over for the card")
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--out", type=Path, default=Path(default_model(GROUND)))
    options = parser.parse_args(arguments)
    begun = time.monotonic()
    camera = load_camera("lepton-160")

    def fields(soils: tuple[str, ...], first: int, count: int, weakest: float) -> Samples:
        return field_samples(camera, soils, range(first, first + count), options.frames, weakest, options.cache)

    plain = fields(TRAINED_SOILS, 0, options.fields, LEAST_LEARNED)
    train = Samples.join([plain, mirrored(plain)])
    calibrate = fields(TRAINED_SOILS, FIRST_CALIBRATION, TEST_FIELDS, LEAST_LEARNED)
    tests = {
        "synthetic, trained soils, other seeds": fields(TRAINED_SOILS, FIRST_TEST, TEST_FIELDS, LEAST_TESTED),
        "synthetic, held-out soil clay": fields(HELD_OUT_SOIL, FIRST_SOIL_TEST, TEST_FIELDS, LEAST_TESTED),
    }
    print(f"{len(train)} samples after {time.monotonic() - begun:.0f} s", flush=True)

    network = fit(train.vectors, train.labels, np.ones(len(train)), options.epochs, options.seed)
    temperature = measure.fit_temperature(calibrate.labels, network.logits(calibrate.vectors))
    layers = fold(network.weights, network.biases, network.mean, network.scale, 1.0 / temperature)
    notes = {"seed": str(options.seed), "temperature": f"{temperature:.4f}"}
    sha256 = write(options.out, GROUND, layers, notes)
    print(f"trained after {time.monotonic() - begun:.0f} s", flush=True)

    classifier = Classifier(options.out, GROUND)
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
    counts = {name: int((train.labels == i).sum()) for i, name in enumerate(CLASSES)}
    text = ground_section(counts, results, driven, notes, sha256, options)
    write_section(options.out.parent / "README.md", options.out.name, text)
    for name, (truth, p) in results.items():
        print(f"\n{name}\n{measure.as_markdown(truth, p)}")
    print(f"\n{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")
