"""Which pictures are held out together, and what a classifier makes of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture.detect import MAX_DETECTIONS, thin

from tools.evaluate.figures import f1
from tools.train.picture.hits import MAX_HEIGHT, hit
from tools.train.picture.records import Record
from tools.train.picture.samples import (
    BACKGROUND,
    BOX,
    BURIED,
    CANDIDATE,
    MINE_UNKNOWN,
    SURFACE,
    WINDOW,
    PictureSamples,
)

# The rate of false alarms at which Pd is read off.
FALSE_ALARMS = 0.3
RANDOM_PARTS = 3
# Zones held out for the learning curve, and the buried zones that are learned from, one more at a time.
FEW_ZONES = {"1": ("3", "9"), "7": ("1", "9")}
# Probabilities (N, 3) of surface, buried and background for rows of the samples.
Judge = Callable[[NDArray[np.intp]], NDArray[np.floating]]


@dataclass(frozen=True, eq=False)
class Fold:
    """name; held_out: pictures (P,) bool that are tested on; known: that are learned from."""

    name: str
    held_out: NDArray[np.bool_]
    known: NDArray[np.bool_]


@dataclass(frozen=True)
class Alarm:
    """One detection: score, picture, index of the box whose halo it hits or -1, its spot; inside: in the box itself."""

    score: float
    picture: int
    box: int
    spot: tuple[float, float, float]
    inside: bool = False


@dataclass(frozen=True, eq=False)
class Outcome:
    """One fold's answers.

    truth, p: of the labelled boxes and the windows beside them. alarms: of whole pictures up to MAX_HEIGHT, with the
    number of mines and pictures, and which those are. candidates: truth and p of every candidate whose truth is known.
    """

    name: str
    truth: NDArray[np.int64]
    p: NDArray[np.floating]
    alarms: list[Alarm]
    mines: int
    pictures: int
    candidates: tuple[NDArray[np.int64], NDArray[np.floating]]
    judged: tuple[int, ...] = ()

    def answers(self, threshold: float) -> NDArray[np.int64]:
        """Class of every box and window: the likelier kind of mine where both together reach the threshold."""
        return np.where(1.0 - self.p[:, 2] >= threshold, self.p[:, :2].argmax(axis=1) + SURFACE, BACKGROUND)

    def figures(self, threshold: float) -> dict[str, float]:
        """F1 of mine, surface and buried, and Pd at FALSE_ALARMS a picture, with the halo and without."""
        answer = self.answers(threshold)
        told = self.truth != MINE_UNKNOWN
        return {
            "mine": f1(self.truth != BACKGROUND, answer != BACKGROUND),
            "surface": f1(self.truth[told] == SURFACE, answer[told] == SURFACE),
            "buried": f1(self.truth[told] == BURIED, answer[told] == BURIED),
            "pd": self.pd_at(FALSE_ALARMS),
            "pd strict": self.pd_at(FALSE_ALARMS, strict=True),
        }

    def pd_at(self, rate: float, strict: bool = False) -> float:
        """Share of the mines found where so many false alarms a picture are let through; strict: without the halo."""
        if not self.mines:
            return math.nan
        hits: set[tuple[int, int]] = set()
        false, best = 0, 0
        for alarm in sorted(self.alarms, key=lambda a: -a.score):
            if alarm.box < 0 or (strict and not alarm.inside):
                false += 1
            else:
                hits.add((alarm.picture, alarm.box))
            if false <= rate * self.pictures:
                best = len(hits)
        return best / self.mines

    def found_at(self, rate: float) -> set[tuple[int, int]]:
        """Picture and box of the mines found where so many false alarms a picture are let through."""
        threshold = self.threshold_at(rate)
        return {(a.picture, a.box) for a in self.alarms if a.box >= 0 and a.score >= threshold}

    def threshold_at(self, rate: float) -> float:
        """The least score that is let through with so many false alarms a picture."""
        false = sorted((a.score for a in self.alarms if a.box < 0), reverse=True)
        allowed = int(rate * self.pictures)
        return math.nextafter(false[allowed], math.inf) if allowed < len(false) else 0.0

    def at_threshold(self, threshold: float) -> tuple[int, int]:
        """Mines found and false alarms among scores from `threshold` on."""
        loud = [a for a in self.alarms if a.score >= threshold]
        return len({(a.picture, a.box) for a in loud if a.box >= 0}), sum(a.box < 0 for a in loud)


def grouped_folds(records: Sequence[Record]) -> list[Fold]:
    """Each zone, then each session."""
    zone, session = np.array([r.zone for r in records]), np.array([r.session for r in records])
    folds = [Fold(f"zone {z}", zone == z, zone != z) for z in sorted(set(zone.tolist()))]
    return folds + [Fold(f"session {s}", session == s, session != s) for s in sorted(set(session.tolist()))]


def random_folds(records: Sequence[Record], seed: int) -> list[Fold]:
    """Pictures dealt out at random: neighbours of every test picture are trained on. It flatters."""
    part = np.random.default_rng([seed, 86]).integers(0, RANDOM_PARTS, len(records))
    return [Fold(f"random {i + 1}", part == i, part != i) for i in range(RANDOM_PARTS)]


def few_zones_folds(records: Sequence[Record]) -> list[tuple[int, Fold]]:
    """Some zones held out, with so many others to learn from."""
    zone = np.array([r.zone for r in records])
    folds = []
    for held_out, others in FEW_ZONES.items():
        for count in range(1, len(others) + 1):
            folds.append((count, Fold(f"zone {held_out}", zone == held_out, np.isin(zone, others[:count]))))
    return folds


def judge_fold(fold: Fold, samples: PictureSamples, records: Sequence[Record], judge: Judge) -> Outcome:
    """What `judge` says of the held-out pictures as they lie on disk."""
    on_disk = fold.held_out[samples.picture] & (samples.round == 0)
    boxes = np.nonzero(on_disk & ((samples.what == BOX) | (samples.what == WINDOW)))[0]
    spots = np.nonzero(on_disk & (samples.what == CANDIDATE))[0]
    p = judge(spots)
    alarms: list[Alarm] = []
    mines = 0
    judged = []
    for picture in np.unique(samples.picture[spots]).tolist():
        record = records[picture]
        if record.height > MAX_HEIGHT:
            continue
        mines += len(record.boxes)
        judged.append(picture)
        here = samples.picture[spots] == picture
        places, scores = samples.spots[spots[here]], 1.0 - p[here, 2]
        for i in thin(places, scores, MAX_DETECTIONS):
            spot = tuple(places[i].tolist())
            inside = hit(record, spot, 0.0) >= 0
            alarms.append(Alarm(float(scores[i]), picture, hit(record, spot), spot, inside))
    truth = samples.truth[spots].astype(np.int64)
    told = np.isin(truth, (SURFACE, BURIED, BACKGROUND))
    return Outcome(
        fold.name,
        samples.truth[boxes].astype(np.int64),
        judge(boxes),
        alarms,
        mines,
        len(judged),
        (truth[told], p[told]),
        tuple(judged),
    )


def thresholds(outcomes: Sequence[Outcome]) -> list[float]:
    """For each fold the threshold with the best F1 of mines in the other folds of its sort (zones, sessions, ...)."""
    found = []
    for outcome in outcomes:
        sort = outcome.name.split()[0]
        others = [o for o in outcomes if o is not outcome and o.name.split()[0] == sort]
        truth = np.concatenate([o.truth for o in others]) != BACKGROUND
        score = np.concatenate([1.0 - o.p[:, 2] for o in others])
        steps = np.unique(score)
        found.append(float(steps[np.argmax([f1(truth, score >= step) for step in steps])]))
    return found
