"""`python -m tools.train ground`: the network for candidates in kelvin and metres, from synthetic fields.

The numbers in the card come from what was never trained on: other seeds, hours of the day that nothing is learned
from (`fields.HELD_OUT_HOURS`), one whole soil.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES, GROUND, Classifier, default_model
from rover.vision.camera.file import load_camera

from tools.bench import detector
from tools.train import measure
from tools.train.card import write_section
from tools.train.export import fold, write
from tools.train.ground.card import ground_section
from tools.train.ground.recipe import field_looks
from tools.train.ground.samples import UNSURE, Looks, turned
from tools.train.network import fall_smoothly, fit

TRAINED_SOILS = ("loam", "dry-sand", "moist-clay")
HELD_OUT_SOIL = ("clay",)
FIRST_CALIBRATION, FIRST_TEST, FIRST_SOIL_TEST = 50_000, 60_000, 70_000
# Fields of each, and looks at one of the tests'.
CALIBRATION_FIELDS, TEST_FIELDS, SOIL_TEST_FIELDS = 40, 60, 100
TEST_FRAMES = 12
MIN_TESTED_KELVIN = 0.5
# Fields that are driven over for the card.
FIRST_DRIVE = 4000


def main(arguments: Sequence[str]) -> None:
    """Trains, writes, measures what was written."""
    parser = argparse.ArgumentParser(prog="python -m tools.train ground", description=__doc__)
    parser.add_argument("--fields", type=int, default=600, help="synthetic fields to learn from")
    parser.add_argument("--frames", type=int, default=24, help="frames per field")
    parser.add_argument("--epochs", type=int, default=18)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drives", type=int, default=12, help="fields that are driven over for the card")
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--out", type=Path, default=Path(default_model(GROUND)))
    options = parser.parse_args(arguments)
    begun = time.monotonic()
    camera = load_camera("lepton-160")

    def looks(first: int, count: int) -> Looks:
        seeds = range(first, first + count)
        return field_looks(camera, TRAINED_SOILS, seeds, options.frames, False, options.cache)

    vectors, labels = learned(looks(0, options.fields))
    calibrate = looks(FIRST_CALIBRATION, CALIBRATION_FIELDS)
    print(f"{len(labels)} samples after {time.monotonic() - begun:.0f} s", flush=True)
    weights = np.ones(len(labels))
    network = fit(vectors, labels, weights, options.epochs, options.seed, fall_smoothly, turned)
    sure = calibrate.labels() != UNSURE
    temperature = measure.fit_temperature(calibrate.labels()[sure], network.logits(calibrate.vectors[sure]))
    layers = fold(network.weights, network.biases, network.mean, network.scale, 1.0 / temperature)
    notes = {"seed": str(options.seed), "temperature": f"{temperature:.4f}"}
    sha256 = write(options.out, GROUND, layers, notes)
    print(f"trained after {time.monotonic() - begun:.0f} s", flush=True)

    classifier = Classifier(options.out, GROUND)
    seen = tests(options.cache, SOIL_TEST_FIELDS)
    results = {name: (tested, classifier.predict(tested.vectors)) for name, tested in seen.items()}
    drives = {
        f"the demo mission, fields {FIRST_DRIVE} and on": False,
        f"other soils and hours, fields {FIRST_DRIVE} and on": True,
    }
    driven = {
        name: (
            f"detector --fields {options.drives} --first {FIRST_DRIVE}" + " --mixed" * mixed,
            detector.as_markdown(detector.drive_all(options.out, options.drives, FIRST_DRIVE, mixed)),
        )
        for name, mixed in drives.items()
        if options.drives
    }
    counts = {name: int((labels == i).sum()) for i, name in enumerate(CLASSES)}
    text = ground_section(counts, results, MIN_TESTED_KELVIN, driven, notes, sha256, options)
    write_section(options.out.parent / "README.md", options.out.name, text)
    for name, (tested, p) in results.items():
        print(f"\n{name}\n{measure.looks_as_markdown(tested, p, MIN_TESTED_KELVIN)}")
    print(f"\n{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {notes}, {time.monotonic() - begun:.0f} s")


def learned(looks: Looks) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Vectors and labels of all candidates that are clearly something."""
    labels = looks.labels()
    return looks.vectors[labels != UNSURE], labels[labels != UNSURE]


def tests(cache: Path | None, most: int) -> dict[str, Looks]:
    """What a network is tested on, by title; `most`: fields of each test, at most."""
    camera, seen = load_camera("lepton-160"), range(FIRST_TEST, FIRST_TEST + min(TEST_FIELDS, most))
    unseen = range(FIRST_SOIL_TEST, FIRST_SOIL_TEST + min(SOIL_TEST_FIELDS, most))
    return {
        "Trained soils, held-out hours": field_looks(camera, TRAINED_SOILS, seen, TEST_FRAMES, True, cache),
        "Held-out soil (clay), held-out hours": field_looks(camera, HELD_OUT_SOIL, unseen, TEST_FRAMES, True, cache),
    }
