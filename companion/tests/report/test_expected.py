"""Specification: the report says what the detector finds only where it was the one that was measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from rover.detection.classifier import GROUND, Classifier, default_model
from rover.detection.model_file import shipped
from rover.report.expected import FILE, expected
from rover.report.result import RunResult

from companion.tests.report.sample_run import make_result


def with_model(model_hash: str) -> RunResult:
    run = make_result()
    return replace(run, identities=replace(run.identities, model_hash=model_hash))


def test_the_figures_that_ship_are_of_the_model_that_ships() -> None:
    told = json.loads(shipped(FILE).read_text())
    assert told["model"] == Classifier(default_model(GROUND), GROUND).sha256
    for row in told["rows"]:
        assert 0 <= row["found"] <= row["mines"]
        assert not row["mines"] or row["low"] <= row["found"] / row["mines"] + 1e-3 <= row["high"] + 2e-3
    mines = {by: sum(row["mines"] for row in told["rows"] if row["by"] == by) for by in ("contrast", "depth")}
    assert mines["contrast"] == mines["depth"] >= 40


def test_a_report_tells_every_class_with_its_interval() -> None:
    told = json.loads(shipped(FILE).read_text())
    page = str(expected(with_model(told["model"][:12])))
    for row in told["rows"]:
        assert row["what"] in page
        assert not row["mines"] or f"{100 * row['low']:.0f} to {100 * row['high']:.0f} %" in page


@pytest.mark.parametrize("other", ["", "0123456789ab"])
def test_figures_of_another_model_are_not_shown(other: str) -> None:
    assert not expected(with_model(other))


def test_a_report_without_the_file_has_no_such_section(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = json.loads(shipped(FILE).read_text())
    monkeypatch.setattr("rover.report.expected.shipped", lambda name: tmp_path / name)
    assert not expected(with_model(told["model"]))
