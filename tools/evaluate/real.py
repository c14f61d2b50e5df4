"""Real pictures: the network and its rivals on the same folds."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES, Classifier

from tools.evaluate.folds import HIGHEST, Fold, Outcome, grouped_folds, hit, judge_fold, random_folds
from tools.evaluate.rivals import patches, rivals
from tools.train.measure import fit_pictures, softmax
from tools.train.network import fit
from tools.train.picture_recipe import picture_samples, picture_set
from tools.train.picture_samples import (
    BACKGROUND,
    BOX,
    BURIED,
    CANDIDATE,
    JITTERED,
    SURFACE,
    WINDOW,
    PictureSamples,
)
from tools.train.records import Record, read_records

THREE = (SURFACE, BURIED, BACKGROUND)
# Candidates without a mine that a rival learns from, of one picture.
RIVAL_GROUND = 2


@dataclass(frozen=True, eq=False)
class RealResults:
    """Outcomes per classifier and kind of split, and the pictures that they are about."""

    grouped: dict[str, list[Outcome]]
    dealt: dict[str, list[Outcome]]
    records: list[Record]
    ceiling: tuple[int, int]
    trained_on: Outcome


def evaluate_real(
    data: Path, seed: int, epochs: int, cache: Path | None, with_rivals: bool, classifier: Classifier
) -> RealResults:
    """Every fold of every classifier. Takes minutes."""
    records = read_records(data)
    samples = picture_samples(records, seed, cache)
    grouped: dict[str, list[Outcome]] = {}
    dealt: dict[str, list[Outcome]] = {}
    for split, folds in ((grouped, grouped_folds(records)), (dealt, random_folds(records, seed))):
        split["this network"] = [_network(fold, samples, records, seed, epochs) for fold in folds]
        for name in rivals(seed) if with_rivals else ():
            split[name] = [_rival(name, fold, samples, records, seed) for fold in folds]
    shipped = _trained_on(samples, records, classifier)
    return RealResults(grouped, dealt, records, _ceiling(samples, records), shipped)


def calibrated(outcomes: Sequence[Outcome]) -> tuple[NDArray[np.int64], NDArray[np.floating]]:
    """Truth and probabilities of all zones' candidates, each zone calibrated by what the others say."""
    zones = [o for o in outcomes if o.name.startswith("zone")]
    truths, answers = [], []
    for index, outcome in enumerate(zones):
        others = [o.candidates for i, o in enumerate(zones) if i != index]
        truth = np.concatenate([t for t, _ in others]) - SURFACE
        logits = np.log(np.concatenate([p for _, p in others]) + 1e-6)
        factor, shift = fit_pictures(truth, logits, BACKGROUND - SURFACE)
        truths.append(outcome.candidates[0] - SURFACE)
        answers.append(softmax(np.log(outcome.candidates[1] + 1e-6) * factor + shift))
    return np.concatenate(truths), np.concatenate(answers)


def _network(fold: Fold, samples: PictureSamples, records: Sequence[Record], seed: int, epochs: int) -> Outcome:
    network = fit(*picture_set(samples, ~fold.held_out[samples.picture], seed), epochs, seed)

    def judge(rows: NDArray[np.intp]) -> NDArray[np.floating]:
        return softmax(network.logits(samples.vectors[rows].astype(np.float32))[:, THREE])

    return _told("this network", judge_fold(fold, samples, records, judge))


def _rival(name: str, fold: Fold, samples: PictureSamples, records: Sequence[Record], seed: int) -> Outcome:
    rng = np.random.default_rng([seed, 87])
    known = ~fold.held_out[samples.picture] & (samples.round == 0)
    mines = known & np.isin(samples.what, (BOX, JITTERED)) & np.isin(samples.truth, (SURFACE, BURIED))
    plain = known & (samples.what == CANDIDATE) & (samples.truth == BACKGROUND)
    ground = np.nonzero(plain)[0]
    few = rng.permutation(ground)[: RIVAL_GROUND * len(np.unique(samples.picture[ground]))]
    rows = np.sort(np.concatenate((np.nonzero(mines | (known & (samples.what == WINDOW)))[0], few)))
    model = rivals(seed)[name].fit(patches(samples, records, rows), samples.truth[rows])

    def judge(chosen: NDArray[np.intp]) -> NDArray[np.floating]:
        if not len(chosen):
            return np.zeros((0, 3))
        shown = patches(samples, records, chosen)
        told = hasattr(model, "predict_proba")
        scores = model.predict_proba(shown) if told else softmax(_margins(model.decision_function(shown)))
        p = np.zeros((len(chosen), 3))
        p[:, [c - SURFACE for c in model.classes_]] = scores
        return p

    return _told(name, judge_fold(fold, samples, records, judge))


def _margins(scores: NDArray[np.floating]) -> NDArray[np.floating]:
    """(N, classes) also where two classes have one margin between them."""
    return scores if scores.ndim == 2 else np.column_stack((-scores, scores))


def _told(name: str, outcome: Outcome) -> Outcome:
    figures = ", ".join(f"{key} {value:.3f}" for key, value in outcome.figures().items())
    print(f"{name}: {outcome.name}: {figures}", file=sys.stderr, flush=True)
    return outcome


def _ceiling(samples: PictureSamples, records: Sequence[Record]) -> tuple[int, int]:
    """Mines of pictures up to HIGHEST that at least one candidate would count for, and all of them."""
    low = {i for i, record in enumerate(records) if record.height <= HIGHEST}
    hits = set()
    for row in np.nonzero((samples.round == 0) & (samples.what == CANDIDATE))[0].tolist():
        picture = int(samples.picture[row])
        if picture in low and (box := hit(records[picture], samples.spots[row].tolist())) >= 0:
            hits.add((picture, box))
    return len(hits), sum(len(records[i].boxes) for i in low)


def _trained_on(samples: PictureSamples, records: Sequence[Record], classifier: Classifier) -> Outcome:
    """What the shipped model says of the pictures that it learned from: no test, but a bound on what it can fit."""

    def judge(rows: NDArray[np.intp]) -> NDArray[np.floating]:
        p = classifier.predict(samples.vectors[rows].astype(np.float32))
        three = p[:, [classifier.classes.index(CLASSES[i]) for i in THREE]]
        return three / np.maximum(three.sum(axis=1, keepdims=True), 1e-9)

    everything = Fold("trained on", np.ones(len(records), bool))
    return _told("shipped model", judge_fold(everything, samples, records, judge))
