"""How the network for pictures learns: what from, how much each sample counts, and again from its own worst errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from rover.detection.model_file import shipped
from rover.detection.picture import candidates, features, maps, occupancy, patch

from tools.train.measure import softmax
from tools.train.network import Network, fit
from tools.train.picture import augment
from tools.train.picture import records as of_records
from tools.train.picture import samples as of_pictures
from tools.train.picture.records import Record
from tools.train.picture.samples import (
    BACKGROUND,
    BURIED,
    CANDIDATE,
    DRAWN,
    MINE_UNKNOWN,
    SURFACE,
    UNSURE,
    WINDOW,
    PictureSamples,
    sample_picture,
)
from tools.train.store import Arrays, digest, kept

Rows = NDArray[np.intp]
# Rows of the samples, their labels and weights; a row may stand there once for each of several labels.
Told = tuple[Rows, NDArray[np.int64], NDArray[np.float64]]

# Rounds of the pictures: as on disk, and altered.
TURNS = 5
# Of the network whose errors show what is hard, and of the one that counts.
FIRST_EPOCHS, EPOCHS = 3, 6
# Learning rate of the first epoch and, as a share of it, of the last; share of the inputs that are left out at random.
RATE, LAST_RATE, LEFT_OUT = 1.5e-3, 0.02, 0.25
# Share of the steps, the last ones, whose weights are averaged.
AVERAGED = 0.2
# Candidates that are no mines, of each picture and round: drawn at random, and the worst of the first network's errors.
GROUND, HARD = 10, 8
# Casings of the pictures count for this share of the buried mines, but none more than so many times; drawn ones count
# for that share of all mines of the pictures, for many are darker or plainer than real ones. All ground counts so much
# more than all mines.
SURFACE_SHARE, MAX_REPEATED, DRAWN_SHARE, GROUND_WEIGHT = 0.5, 4.0, 0.15, 2.0
PART = 8192
MODULES = (candidates, features, maps, occupancy, patch, augment, of_pictures, of_records)
SOURCES = (*(Path(str(module.__file__)) for module in MODULES), shipped(features.FILE))


def picture_samples(records: Sequence[Record], seed: int, cache: Path | None, turns: int = TURNS) -> PictureSamples:
    """Samples of every picture, `turns` times each."""

    def make(turn: int) -> Arrays:
        parts = [sample_picture(record, number, turn, seed) for number, record in enumerate(records)]
        return dict(vars(PictureSamples.join(parts)))

    name = f"pictures-{digest(SOURCES)}-{seed}"
    rounds = [kept(cache, f"{name}-{turn}", partial(make, turn)) for turn in range(turns)]
    return PictureSamples.join([PictureSamples(**arrays) for arrays in rounds])


@dataclass(frozen=True, eq=False)
class Learned:
    """The network and the rows of the samples that it has learned from."""

    network: Network
    mines: Rows
    ground: Rows


def logits(network: Network, vectors: NDArray[np.floating]) -> NDArray[np.float32]:
    """(N, 3) of surface, buried and background."""
    parts = [network.logits(vectors[begin : begin + PART]) for begin in range(0, len(vectors), PART)]
    return np.concatenate(parts)[:, SURFACE:] if parts else np.zeros((0, 3), np.float32)


def probabilities(network: Network, vectors: NDArray[np.floating]) -> NDArray[np.floating]:
    """(N, 3) of surface, buried and background, not calibrated."""
    return softmax(logits(network, vectors))


def learn(samples: PictureSamples, rows: NDArray[np.bool_], seed: int) -> Learned:
    """A network from the samples where `rows` (N,) is True: first with random ground, then also with what it
    confused."""
    mines, ground = drawn(samples, rows, seed)
    plain = samples.round == 0
    index, labels, weights = weighted(samples, mines[plain[mines]], ground[plain[ground]])
    first = fit(samples.vectors[index], labels, weights, FIRST_EPOCHS, seed, falling, varied)
    ground = np.union1d(ground, hardest(samples, rows, first))
    index, labels, weights = weighted(samples, mines, ground)
    network = fit(samples.vectors[index], labels, weights, EPOCHS, seed, falling, varied, AVERAGED)
    return Learned(network, mines, ground)


def falling(done: float) -> float:
    """Learning rate after the share `done` of all epochs: half a cosine."""
    return RATE * (LAST_RATE + (1.0 - LAST_RATE) * 0.5 * (1.0 + math.cos(math.pi * done)))


def varied(vectors: NDArray[np.float32], _labels: NDArray[np.integer], rng: np.random.Generator) -> NDArray[np.float32]:
    """Standardised vectors with some of their numbers left out and the others made up for it."""
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
        said = network.logits(samples.vectors[plain[begin : begin + PART]])
        margin[begin : begin + PART] = said[:, (SURFACE, BURIED)].max(axis=1) - said[:, BACKGROUND]
    group = samples.picture[plain].astype(np.int64) * 100 + samples.round[plain]
    order = np.lexsort((-margin, group))
    begins = np.flatnonzero(np.diff(group[order], prepend=-1))
    place = np.arange(len(order)) - np.repeat(begins, np.diff(np.append(begins, len(order))))
    return plain[order[place < HARD]]


def weighted(samples: PictureSamples, mines: Rows, ground: Rows) -> Told:
    """Rows, labels and weights. A mine of unknown kind is learned as half of either."""
    truth = samples.truth[mines].astype(np.int64)
    untold = truth == MINE_UNKNOWN
    index = np.concatenate((mines, mines[untold], ground))
    labels = np.concatenate(
        (np.where(untold, BURIED, truth), np.full(untold.sum(), SURFACE), np.full(len(ground), BACKGROUND))
    )
    weights = np.ones(len(index))
    weights[: len(mines)][untold] = 0.5
    weights[len(mines) : len(mines) + untold.sum()] = 0.5
    mine, laid = labels != BACKGROUND, samples.box[index] == DRAWN
    buried, surface = labels == BURIED, (labels == SURFACE) & ~laid
    kept = min(MAX_REPEATED, SURFACE_SHARE * weights[buried].sum() / max(weights[surface].sum(), 1.0))
    weights[surface] *= kept
    weights[laid] *= DRAWN_SHARE * weights[mine & ~laid].sum() / max(weights[laid].sum(), 1.0)
    weights[~mine] *= GROUND_WEIGHT * weights[mine].sum() / max(len(ground), 1)
    return index, labels, weights


assert tuple(CLASSES.index(n) for n in ("surface", "buried", "background")) == (SURFACE, BURIED, BACKGROUND)
