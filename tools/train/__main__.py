"""`python -m tools.train [--data DIR]`: trains the classifier and writes it with its model card.

What the numbers in the card come from was never trained on: one whole soil, other seeds, whole zones of pictures.
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
from sklearn.neural_network import MLPClassifier

from tools.bench import detector
from tools.train import measure
from tools.train.card import card
from tools.train.export import fold, write
from tools.train.pictures import from_pictures, zones
from tools.train.samples import Samples, from_fields, mirrored

HIDDEN = (256, 128)
TRAINED_SOILS = ("loam", "dry-sand", "moist-clay")
HELD_OUT_SOIL = ("clay",)
# Every third zone of the pictures is held out, counted from the second.
HELD_OUT_ZONES = slice(1, None, 3)
FIRST_CALIBRATION, FIRST_TEST, FIRST_SOIL_TEST = 50_000, 60_000, 70_000
# Fields that are driven over for the card.
FIRST_DRIVE, DRIVES = 4000, 20


def main() -> None:
    """Trains, writes, measures what was written."""
    parser = argparse.ArgumentParser(prog="python -m tools.train", description=__doc__)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--fields", type=int, default=360, help="synthetic fields to learn from")
    parser.add_argument("--frames", type=int, default=20, help="frames per field")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(default_model()))
    options = parser.parse_args()
    begun = time.monotonic()
    camera = load_camera("lepton-160")

    parts = [from_fields(camera, TRAINED_SOILS, range(options.fields), options.frames)]
    pictures: dict[str, Samples] = {}
    held_out: list[str] = []
    if options.data is not None:
        data = Path(options.data)
        known = zones(data)
        held_out = known[HELD_OUT_ZONES]
        parts.append(from_pictures(data, [zone for zone in known if zone not in held_out], options.seed))
        pictures["real pictures, held-out zones " + ", ".join(held_out)] = from_pictures(data, held_out, options.seed)
    train = Samples.join(parts)
    print(f"{len(train)} samples {train.counts()} after {time.monotonic() - begun:.0f} s")

    few = max(8, options.fields // 15)
    calibrate = from_fields(camera, TRAINED_SOILS, _seeds(FIRST_CALIBRATION, few), options.frames)
    tests = {
        "synthetic, trained soils, other seeds": from_fields(
            camera, TRAINED_SOILS, _seeds(FIRST_TEST, few), options.frames, weakest=0.0
        ),
        "synthetic, held-out soil clay": from_fields(
            camera, HELD_OUT_SOIL, _seeds(FIRST_SOIL_TEST, few), options.frames, weakest=0.0
        ),
        **pictures,
    }
    train = Samples.join([train, mirrored(train)])
    mean, scale = train.vectors.mean(axis=0), train.vectors.std(axis=0) + 1e-3
    network = MLPClassifier(
        HIDDEN, alpha=2e-2, batch_size=256, learning_rate_init=7e-4, max_iter=options.epochs, random_state=options.seed
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        network.fit(((train.vectors - mean) / scale).astype(np.float32), train.labels)
    plain = fold(network.coefs_, network.intercepts_, mean, scale, 1.0)
    temperature = measure.fit_temperature(calibrate.labels, _logits(plain, calibrate.vectors))
    layers = fold(network.coefs_, network.intercepts_, mean, scale, temperature)
    write(options.out, layers, {"seed": str(options.seed), "temperature": f"{temperature:.4f}"})

    classifier = Classifier(options.out)
    results = {name: (s.labels, classifier.predict(s.vectors)) for name, s in tests.items() if len(s)}
    drives = {
        f"the demo mission, fields {FIRST_DRIVE} and on": detector.drive_all(options.out, DRIVES, FIRST_DRIVE, False),
        f"other soils and hours, fields {FIRST_DRIVE} and on (--mixed)": detector.drive_all(
            options.out, DRIVES, FIRST_DRIVE, True
        ),
    }
    driven = {name: detector.as_markdown(runs) for name, runs in drives.items()}
    text = card(train, results, driven, temperature, hashlib.sha256(options.out.read_bytes()).hexdigest(), options)
    (options.out.parent / "README.md").write_text(text, encoding="utf-8")
    for name, (labels, p) in results.items():
        print(f"\n{name}\n{measure.as_markdown(labels, p)}")
    print(f"\n{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {', '.join(CLASSES)}, ", end="")
    print(f"temperature {temperature:.2f}, {time.monotonic() - begun:.0f} s")


def _seeds(first: int, count: int) -> range:
    return range(first, first + count)


def _logits(layers: list, vectors: np.ndarray) -> np.ndarray:
    flow = vectors
    for weight, bias in layers[:-1]:
        flow = np.maximum(flow @ weight + bias, 0.0)
    return flow @ layers[-1][0] + layers[-1][1]


if __name__ == "__main__":
    main()
