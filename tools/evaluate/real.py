"""Real pictures: the network and its rivals on the same folds, the same candidates and the same numbers."""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rover.detection.classifier import CLASSES, Classifier

from tools.evaluate.folds import Fold, Judge, Outcome, few_zones_folds, grouped_folds, judge_fold, random_folds
from tools.evaluate.rivals import rival_judge, rivals
from tools.train.measure import fit_pictures, softmax
from tools.train.picture.hits import MAX_HEIGHT, hit
from tools.train.picture.recipe import learn, picture_samples, probabilities
from tools.train.picture.records import Record, read_records
from tools.train.picture.samples import BACKGROUND, BURIED, CANDIDATE, MINE_UNKNOWN, SURFACE, PictureSamples

THREE = (SURFACE, BURIED, BACKGROUND)
OWN = "this network"


@dataclass(frozen=True, eq=False)
class RealResults:
    """Outcomes of zones and sessions held out by classifier, and of this network: of pictures dealt out at random, and
    of zones after learning from so many others.

    ceiling: mines of pictures up to MAX_HEIGHT with a candidate at their place, with one of their size there too, all.
    trained_on: what the shipped model says of the pictures that it learned from.
    """

    grouped: dict[str, list[Outcome]]
    dealt: list[Outcome]
    few: dict[int, list[Outcome]]
    records: list[Record]
    ceiling: tuple[int, int, int]
    trained_on: Outcome


@dataclass(frozen=True, eq=False)
class _Work:
    """What every process needs; inherited by them, not sent."""

    samples: PictureSamples
    records: Sequence[Record]
    seed: int


_work: list[_Work] = []


def evaluate_real(
    data: Path, seed: int, cache: Path | None, with_rivals: bool, jobs: int, classifier: Classifier
) -> RealResults:
    """Every fold of every classifier, `jobs` at a time; progress on stderr."""
    records = read_records(data)
    samples = picture_samples(records, seed, cache)
    few = few_zones_folds(records)
    tasks = [(fold, with_rivals) for fold in grouped_folds(records)]
    tasks += [(fold, False) for fold in (*random_folds(records, seed), *(fold for _, fold in few))]
    _work[:] = [_Work(samples, records, seed)]
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("fork")) as pool:
        working = pool.map(_judged, tasks)
        found = list(track(working, "folds of real pictures", len(tasks), console=Console(stderr=True)))
    held_out = len(grouped_folds(records))
    curve: dict[int, list[Outcome]] = {}
    for (zones, _), outcomes in zip(few, found[len(found) - len(few) :], strict=True):
        curve.setdefault(zones, []).append(outcomes[OWN])
    return RealResults(
        {name: [outcomes[name] for outcomes in found[:held_out]] for name in found[0]},
        [outcomes[OWN] for outcomes in found[held_out : len(found) - len(few)]],
        curve,
        records,
        _ceiling(samples, records),
        _trained_on(samples, records, classifier),
    )


def _judged(task: tuple[Fold, bool]) -> dict[str, Outcome]:
    """Outcomes by classifier: the network learns from what is not held out, its rivals from the same rows on disk."""
    (fold, with_rivals), work = task, _work[0]
    samples = work.samples
    learned = learn(samples, fold.known[samples.picture], work.seed)
    judges: dict[str, Judge] = {OWN: lambda rows: probabilities(learned.network, samples.vectors[rows])}
    if with_rivals:
        for name, model in rivals(work.seed).items():
            judges[name] = rival_judge(name, model, samples, work.records, learned, work.seed)
    return {name: judge_fold(fold, samples, work.records, judge) for name, judge in judges.items()}


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


def _ceiling(samples: PictureSamples, records: Sequence[Record]) -> tuple[int, int, int]:
    low = [i for i, record in enumerate(records) if record.height <= MAX_HEIGHT]
    here = (samples.round == 0) & (samples.what == CANDIDATE) & np.isin(samples.picture, low)
    near, fitting = set(), set()
    for row in np.nonzero(here)[0].tolist():
        picture = int(samples.picture[row])
        if (box := hit(records[picture], samples.spots[row].tolist())) >= 0:
            near.add((picture, box))
        if samples.truth[row] in (SURFACE, BURIED, MINE_UNKNOWN):
            fitting.add((picture, int(samples.box[row])))
    return len(near), len(fitting), sum(len(records[i].boxes) for i in low)


def _trained_on(samples: PictureSamples, records: Sequence[Record], classifier: Classifier) -> Outcome:
    """What the shipped model says of the pictures that it learned from: no test, but a bound on what it can fit."""

    def judge(rows: NDArray[np.intp]) -> NDArray[np.floating]:
        p = classifier.predict(samples.vectors[rows].astype(np.float32))
        three = p[:, [classifier.classes.index(CLASSES[i]) for i in THREE]]
        shares: NDArray[np.float32] = three / np.maximum(three.sum(axis=1, keepdims=True), 1e-9)
        return shares

    everything = np.ones(len(records), bool)
    return judge_fold(Fold("trained on", everything, everything), samples, records, judge)
