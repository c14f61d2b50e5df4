"""What the network for pictures learns from, and how much each sample counts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES

from tools.train.picture_samples import (
    BACKGROUND,
    BURIED,
    CANDIDATE,
    MINE_UNKNOWN,
    SURFACE,
    UNSURE,
    PictureSamples,
    sample_picture,
)
from tools.train.records import Record
from tools.train.store import kept

# Rounds of the pictures: as on disk, and altered.
TURNS = 3
# Candidates of an unaltered picture that are no mines: so many are learned from.
GROUND_PER_PICTURE = 30
# No class of mine counts more than so many times for being rare; all ground counts so much more than all mines.
MOST_REPEATED, GROUND_WEIGHT = 4.0, 2.0

Set = tuple[NDArray[np.floating], NDArray[np.int64], NDArray[np.float64]]


def picture_samples(records: Sequence[Record], seed: int, cache: Path | None, turns: int = TURNS) -> PictureSamples:
    """Samples of every picture, `turns` times each."""

    def make(turn: int) -> dict[str, NDArray]:
        parts = [sample_picture(record, number, turn, seed) for number, record in enumerate(records)]
        return dict(vars(PictureSamples.join(parts)))

    rounds = [kept(cache, f"pictures-{seed}-{turn}", lambda turn=turn: make(turn)) for turn in range(turns)]
    return PictureSamples.join([PictureSamples(**arrays) for arrays in rounds])


def picture_set(samples: PictureSamples, rows: NDArray[np.bool_], seed: int) -> Set:
    """Vectors, labels and weights to learn from, out of the samples where `rows` (N,) is True.

    A mine of unknown kind is learned as half of either.
    """
    rng = np.random.default_rng([seed, 85])
    use = rows & (samples.truth != UNSURE)
    plain = np.nonzero((samples.round == 0) & (samples.what == CANDIDATE) & (samples.truth == BACKGROUND))[0]
    pictures = max(len(np.unique(samples.picture)), 1)
    use[plain[rng.random(len(plain)) >= GROUND_PER_PICTURE * pictures / max(len(plain), 1)]] = False
    chosen = np.nonzero(use)[0]
    truth = samples.truth[chosen].astype(np.int64)
    untold = truth == MINE_UNKNOWN
    index = np.concatenate((chosen, chosen[untold]))
    labels = np.concatenate((np.where(untold, BURIED, truth), np.full(untold.sum(), SURFACE)))
    weights = np.ones(len(index))
    weights[: len(chosen)][untold] = 0.5
    weights[len(chosen) :] = 0.5
    mines = weights[labels != BACKGROUND].sum()
    for kind in (SURFACE, BURIED):
        weights[labels == kind] *= min(MOST_REPEATED, 0.5 * mines / max(weights[labels == kind].sum(), 1.0))
    ground = labels == BACKGROUND
    weights[ground] *= GROUND_WEIGHT * mines / max(weights[ground].sum(), 1.0)
    return samples.vectors[index], labels, weights


assert tuple(CLASSES.index(n) for n in ("surface", "buried", "background")) == (SURFACE, BURIED, BACKGROUND)
