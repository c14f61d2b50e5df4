"""Which pictures are held out together, and what a classifier makes of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture_detect import MOST, thin

from tools.evaluate.figures import f1
from tools.train.picture_samples import (
    BACKGROUND,
    BOX,
    BURIED,
    CANDIDATE,
    MINE_UNKNOWN,
    SURFACE,
    WINDOW,
    PictureSamples,
)
from tools.train.records import Record

# Whole pictures count up to this height, metres; the rate of false alarms at which Pd is read off.
HIGHEST, FALSE_ALARMS = 4.0, 0.3
RANDOM_PARTS = 3
# A detection counts within the box and 10 cm around it. Heights are unreliable, so 10 cm are told by the boxes: buried
# mines are about 27 cm wide in them, surface mines 15 cm; the lesser halo of the two serves for both.
HALO = 0.37

Judge = Callable[[NDArray[np.intp]], NDArray[np.floating]]
"""Probabilities (N, 3) of surface, buried and background for rows of the samples."""


@dataclass(frozen=True, eq=False)
class Fold:
    """name; held_out: pictures (P,) bool that are tested on."""

    name: str
    held_out: NDArray[np.bool_]


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

    truth, p: of the labelled boxes and the windows beside them. alarms: of whole pictures up to HIGHEST, with the
    number of mines and pictures. candidates: truth and p of every candidate whose truth is known.
    """

    name: str
    truth: NDArray[np.int64]
    p: NDArray[np.floating]
    alarms: list[Alarm]
    mines: int
    pictures: int
    candidates: tuple[NDArray[np.int64], NDArray[np.floating]]

    def figures(self) -> dict[str, float]:
        """F1 of mine, surface and buried, and Pd at FALSE_ALARMS a picture, with the halo and without."""
        kind = self.p.argmax(axis=1) + SURFACE
        told = self.truth != MINE_UNKNOWN
        return {
            "mine": f1(self.truth != BACKGROUND, self.p[:, 2] < 0.5),
            "surface": f1(self.truth[told] == SURFACE, kind[told] == SURFACE),
            "buried": f1(self.truth[told] == BURIED, kind[told] == BURIED),
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

    def at_threshold(self, threshold: float) -> tuple[int, int]:
        """Mines found and false alarms among scores from `threshold` on."""
        loud = [a for a in self.alarms if a.score >= threshold]
        return len({(a.picture, a.box) for a in loud if a.box >= 0}), sum(a.box < 0 for a in loud)


def grouped_folds(records: Sequence[Record]) -> list[Fold]:
    """Each zone, then each session."""
    zones, sessions = sorted({r.zone for r in records}), sorted({r.session for r in records})
    return [Fold(f"zone {z}", np.array([r.zone == z for r in records])) for z in zones] + [
        Fold(f"session {s}", np.array([r.session == s for r in records])) for s in sessions
    ]


def random_folds(records: Sequence[Record], seed: int) -> list[Fold]:
    """Pictures dealt out at random: neighbours of every test picture are trained on. It flatters."""
    part = np.random.default_rng([seed, 86]).integers(0, RANDOM_PARTS, len(records))
    return [Fold(f"random {i + 1}", part == i) for i in range(RANDOM_PARTS)]


def judge_fold(fold: Fold, samples: PictureSamples, records: Sequence[Record], judge: Judge) -> Outcome:
    """What `judge` says of the held-out pictures as they lie on disk."""
    on_disk = fold.held_out[samples.picture] & (samples.round == 0)
    boxes = np.nonzero(on_disk & ((samples.what == BOX) | (samples.what == WINDOW)))[0]
    spots = np.nonzero(on_disk & (samples.what == CANDIDATE))[0]
    p = judge(spots)
    alarms: list[Alarm] = []
    mines = pictures = 0
    for picture in np.unique(samples.picture[spots]).tolist():
        record = records[picture]
        if record.height > HIGHEST:
            continue
        mines, pictures = mines + len(record.boxes), pictures + 1
        here = samples.picture[spots] == picture
        places, scores = samples.spots[spots[here]], 1.0 - p[here, 2]
        for i in thin(places, scores, MOST):
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
        pictures,
        (truth[told], p[told]),
    )


def hit(record: Record, spot: Sequence[float], around: float = HALO) -> int:
    """The box whose halo holds the middle of a spot."""
    for index, box in enumerate(record.boxes):
        halo = around * box.side
        if abs(spot[0] - box.x) < 0.5 * box.width + halo and abs(spot[1] - box.y) < 0.5 * box.height + halo:
            return index
    return -1
