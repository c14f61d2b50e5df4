"""Specification: a model that is not the one that was evaluated is refused in one line, before a mission starts."""

from __future__ import annotations

import shutil
from pathlib import Path

import onnx
import pytest
from onnx import numpy_helper
from rover.detection.classifier import GROUND, LENGTHS, PICTURES, Classifier, default_model
from rover.errors import BadInput


@pytest.fixture(params=tuple(LENGTHS))
def kind(request: pytest.FixtureRequest) -> str:
    """Each of the two networks in turn."""
    return str(request.param)


@pytest.fixture
def model(kind: str, tmp_path: Path) -> Path:
    """A copy of the model that ships, with the hash beside it."""
    shipped = Path(default_model(kind))
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


def rewrite(model: Path, **notes: str) -> None:
    """Other metadata in the same file; the hash beside it is taken away."""
    graph = onnx.load(model)
    onnx.helper.set_model_props(graph, {p.key: p.value for p in graph.metadata_props} | notes)
    onnx.save(graph, model)
    model.with_suffix(".sha256").unlink()


def test_the_model_that_ships_is_the_one_that_its_hash_names(model: Path, kind: str) -> None:
    assert Classifier(model, kind).sha256 == model.with_suffix(".sha256").read_text().split()[0]


def test_a_changed_weight_is_noticed_by_the_hash(model: Path, kind: str) -> None:
    spoil(model, 0.5)
    with pytest.raises(BadInput, match="SHA-256"):
        Classifier(model, kind)


def test_weights_that_are_no_numbers_are_refused_even_without_a_hash(model: Path, kind: str) -> None:
    spoil(model, float("nan"))
    model.with_suffix(".sha256").unlink()
    with pytest.raises(BadInput, match="no probabilities"):
        Classifier(model, kind)


def test_a_network_of_the_other_kind_is_refused_with_what_it_is_for(model: Path, kind: str) -> None:
    other = GROUND if kind == PICTURES else PICTURES
    with pytest.raises(BadInput, match=f"a network for {kind}, one for {other} is needed"):
        Classifier(model, other)


def test_a_file_may_say_itself_which_kind_it_is(model: Path, kind: str) -> None:
    assert Classifier(model, None).kind == kind


def test_other_classes_are_refused(model: Path, kind: str) -> None:
    rewrite(model, classes="mine,background")
    with pytest.raises(BadInput, match="classes are mine, background"):
        Classifier(model, kind)


def test_another_number_of_inputs_is_refused(model: Path, kind: str) -> None:
    rewrite(model, kind=GROUND if kind == PICTURES else PICTURES)
    with pytest.raises(BadInput, match=r"takes \d+ numbers per candidate, this version gives \d+"):
        Classifier(model, None)
