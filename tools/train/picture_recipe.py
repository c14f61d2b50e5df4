"""How the network for pictures learns: what from, how much each sample counts, and again from its own worst errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection import picture_candidates, picture_circles, picture_maps, picture_patch
from rover.detection.classifier import CLASSES

from tools.train import augment
from tools.train import picture_samples as of_pictures
from tools.train import records as of_records
from tools.train.measure import softmax
from tools.train.network import Network, fit
from tools.train.picture_samples import (
    BACKGROUND,
    BURIED,
    CANDIDATE,
    MINE_UNKNOWN,
    SURFACE,
    UNSURE,
    WINDOW,
    PictureSamples,
    sample_picture,
)
from tools.train.records import Record
from tools.train.store import digest, kept

# Rounds of the pictures: as on disk, and altered.
TURNS = 3
# Of the network whose errors show what is hard, and of the one that counts.
FIRST_EPOCHS, EPOCHS = 4, 7
# Learning rate of the first epoch and, as a share of it, of the last; share of the inputs that are left out at random.
RATE, LAST_RATE, LEFT_OUT = 1.5e-3, 0.02, 0.25
# Candidates that are no mines, of each picture and round: drawn at random, and the worst of the first network's errors.
GROUND, HARD = 10, 8
# No class of mine counts more than so many times for being rare; all ground counts so much more than all mines.
MOST_REPEATED, GROUND_WEIGHT = 4.0, 2.0
PART = 8192
MODULES = (picture_candidates, picture_circles, picture_maps, picture_patch, augment, of_pictures, of_records)
SOURCES = tuple(Path(str(module.__file__)) for module in MODULES)

Rows = NDArray[np.intp]
Set = tuple[NDArray[np.floating], NDArray[np.int64], NDArray[np.float64]]


def picture_samples(records: Sequence[Record], seed: int, cache: Path | None, turns: int = TURNS) -> PictureSamples:
    """Samples of every picture, `turns` times each."""

    def make(turn: int) -> dict[str, NDArray]:
        parts = [sample_picture(record, number, turn, seed) for number, record in enumerate(records)]
        return dict(vars(PictureSamples.join(parts)))

    name = f"pictures-{digest(SOURCES)}-{seed}"
    rounds = [kept(cache, f"{name}-{turn}", lambda turn=turn: make(turn)) for turn in range(turns)]
    return PictureSamples.join([PictureSamples(**arrays) for arrays in rounds])


@dataclass(frozen=True, eq=False)
class Learned:
    """The network and the rows of the samples that it has learned from."""

    network: Network
    mines: Rows
    ground: Rows

    def probabilities(self, vectors: NDArray[np.floating]) -> NDArray[np.floating]:
        """(N, 3) of surface, buried and background."""
        logits = [self.network.logits(vectors[i : i + PART])[:, SURFACE:] for i in range(0, len(vectors), PART)]
        return softmax(np.concatenate([np.zeros((0, 3), np.float32), *logits]))


def learn(samples: PictureSamples, rows: NDArray[np.bool_], seed: int) -> Learned:
    """A network from the samples where `rows` (N,) is True: first with random ground, then with what it confused."""
    mines, ground = drawn(samples, rows, seed)
    plain = samples.round == 0
    some = weighted(samples, mines[plain[mines]], ground[plain[ground]])
    first = fit(*some, FIRST_EPOCHS, seed, falling, thinned_out)
    ground = np.union1d(ground, hardest(samples, rows, first))
    return Learned(fit(*weighted(samples, mines, ground), EPOCHS, seed, falling, thinned_out), mines, ground)


def falling(done: float) -> float:
    """Learning rate after the share `done` of all epochs: half a cosine."""
    return RATE * (LAST_RATE + (1.0 - LAST_RATE) * 0.5 * (1.0 + math.cos(math.pi * done)))


def thinned_out(
    vectors: NDArray[np.float32], _labels: NDArray[np.integer], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Standardised vectors with some of their numbers left out, and the others made up for it."""
    vectors *= (rng.random(vectors.shape, dtype=np.float32) >= LEFT_OUT) * np.float32(1.0 / (1.0 - LEFT_OUT))
    return vectors


def drawn(samples: PictureSamples, rows: NDArray[np.bool_], seed: int) -> tuple[Rows, Rows]:
    """Rows of mines, and of ground drawn at random beside all windows."""
    rng = np.random.default_rng([seed, 85])
    plain = rows & (samples.truth == BACKGROUND)
    pictures = len(np.unique(samples.picture[rows])) * len(np.unique(samples.round[rows]))
    share = GROUND * pictures / max(int(plain.sum()), 1)
    chosen = plain & ((rng.random(len(samples)) < share) | (samples.what == WINDOW))
    return np.nonzero(rows & ~np.isin(samples.truth, (BACKGROUND, UNSURE)))[0], np.nonzero(chosen)[0]


def hardest(samples: PictureSamples, rows: NDArray[np.bool_], network: Network) -> Rows:
    """Of every picture and round the HARD candidates on the ground that the network takes most for mines."""
    plain = np.nonzero(rows & (samples.what == CANDIDATE) & (samples.truth == BACKGROUND))[0]
    margin = np.empty(len(plain), np.float32)
    for begin in range(0, len(plain), PART):
        logits = network.logits(samples.vectors[plain[begin : begin + PART]])
        margin[begin : begin + PART] = logits[:, (SURFACE, BURIED)].max(axis=1) - logits[:, BACKGROUND]
    group = samples.picture[plain].astype(np.int64) * 100 + samples.round[plain]
    order = np.lexsort((-margin, group))
    begins = np.flatnonzero(np.diff(group[order], prepend=-1))
    place = np.arange(len(order)) - np.repeat(begins, np.diff(np.append(begins, len(order))))
    return plain[order[place < HARD]]


def weighted(samples: PictureSamples, mines: Rows, ground: Rows) -> Set:
    """Vectors, labels and weights. A mine of unknown kind is learned as half of either."""
    truth = samples.truth[mines].astype(np.int64)
    untold = truth == MINE_UNKNOWN
    index = np.concatenate((mines, mines[untold], ground))
    labels = np.concatenate(
        (np.where(untold, BURIED, truth), np.full(untold.sum(), SURFACE), np.full(len(ground), BACKGROUND))
    )
    weights = np.ones(len(index))
    weights[: len(mines)][untold] = 0.5
    weights[len(mines) : len(mines) + untold.sum()] = 0.5
    total = weights[labels != BACKGROUND].sum()
    for kind in (SURFACE, BURIED):
        weights[labels == kind] *= min(MOST_REPEATED, 0.5 * total / max(weights[labels == kind].sum(), 1.0))
    weights[labels == BACKGROUND] *= GROUND_WEIGHT * total / max(len(ground), 1)
    return samples.vectors[index], labels, weights


assert tuple(CLASSES.index(n) for n in ("surface", "buried", "background")) == (SURFACE, BURIED, BACKGROUND)
