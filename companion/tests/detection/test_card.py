"""Specification: the model card states what the files say of themselves, and figures that agree with each other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rover.detection.classifier import GROUND, PICTURES, Classifier, default_model
from rover.detection.model_file import shipped

CARD = shipped("README.md").read_text(encoding="utf-8")
MAX_MEGABYTES = 12.0


@pytest.mark.parametrize("kind", [GROUND, PICTURES])
def test_the_card_names_the_files_that_ship(kind: str) -> None:
    assert f"SHA-256: `{Classifier(default_model(kind), kind).sha256}`" in CARD


def test_the_card_states_the_threshold_and_rates_inside_their_intervals() -> None:
    text = " ".join(CARD.split())
    classifier = Classifier(default_model(PICTURES), PICTURES)
    stated = re.search(r"The file's threshold, ([\d.]+), lets ([\d.]+) false alarms a picture", text)
    assert stated is not None
    assert float(stated[1]) == pytest.approx(classifier.threshold, abs=1e-4)
    rates = re.search(r"probability of detection ([\d.]+) \[([\d.]+), ([\d.]+)\], false alarms a picture (\S+)", text)
    alarms = re.search(r"false alarms a picture ([\d.]+) \[([\d.]+), ([\d.]+)\]", text)
    assert rates is not None
    assert alarms is not None
    for value, low, high in ([float(part) for part in found.groups()[:3]] for found in (rates, alarms)):
        assert low < value < high
    assert float(alarms[1]) <= float(stated[2]), "no more than the threshold is chosen for"


def test_all_model_files_together_are_small() -> None:
    files = Path(default_model(PICTURES)).parent.glob("*.onnx")
    assert sum(file.stat().st_size for file in files) < MAX_MEGABYTES * 1e6
