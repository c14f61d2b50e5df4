"""Specification: a model that is not the one that was evaluated is refused in one line, before a mission starts."""

from __future__ import annotations

import shutil
from pathlib import Path

import onnx
import pytest
from onnx import numpy_helper
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A copy of the model that ships, with the hash beside it."""
    shipped = Path(default_model())
    for file in (shipped, shipped.with_suffix(".sha256")):
        shutil.copy(file, tmp_path)
    return tmp_path / shipped.name


def spoil(model: Path, value: float) -> None:
    """Sets every weight of the first layer."""
    graph = onnx.load(model)
    weight = graph.graph.initializer[0]
    values = numpy_helper.to_array(weight).copy()
    values[:] = value
    weight.CopyFrom(numpy_helper.from_array(values, weight.name))
    onnx.save(graph, model)


def test_the_model_that_ships_is_the_one_that_its_hash_names(model: Path) -> None:
    assert Classifier(model).sha256 == model.with_suffix(".sha256").read_text().split()[0]


def test_a_changed_weight_is_noticed_by_the_hash(model: Path) -> None:
    spoil(model, 0.5)
    with pytest.raises(BadInput, match="SHA-256"):
        Classifier(model)


def test_weights_that_are_no_numbers_are_refused_even_without_a_hash(model: Path) -> None:
    spoil(model, float("nan"))
    model.with_suffix(".sha256").unlink()
    with pytest.raises(BadInput, match="no probabilities"):
        Classifier(model)
