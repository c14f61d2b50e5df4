"""What the network for pictures is taught beside labels: what another network and gradient boosting say together.

Boosting goes wrong at other mines than a network does. One network that learns half from labels and half from the
answers of both takes over a part of what the two know together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture.patch import MIRRORED
from sklearn.ensemble import HistGradientBoostingClassifier

from tools.train.export import fold
from tools.train.measure import softmax
from tools.train.network import Network
from tools.train.picture.samples import BACKGROUND, BURIED, MINE_UNKNOWN, SURFACE, UNSURE, PictureSamples

# Unaltered rows that boosting learns from, at most; its trees, and the share of the numbers that a split chooses from.
MAX_ROWS, TREES, FEATURES = 4000, 60, 0.2
# Candidates without a label that are learned from too: this share of those that do not fit a box, and so much ground.
UNSURE_SHARE, OTHER_GROUND = 0.6, 10_000
# The answers' share of what is learned of a sample, the rest is its label's; what is less likely is not learned.
TAUGHT, MIN_PROBABILITY = 0.5, 0.02
PART = 8192

Rows = NDArray[np.intp]
# Rows of the samples, their labels and weights; a row may stand there once for each of several labels.
Told = tuple[Rows, NDArray[np.int64], NDArray[np.float64]]


def unlabelled(samples: PictureSamples, rows: NDArray[np.bool_], labelled: Rows, seed: int) -> Rows:
    """Some where `rows` (N,) is True that are not labelled: of what does not fit a box, and of the ground."""
    rng = np.random.default_rng(seed + 4)
    left = rows.copy()
    left[labelled] = False
    unsure = np.nonzero(left & (samples.truth == UNSURE))[0]
    ground = np.nonzero(left & (samples.truth == BACKGROUND))[0]
    unsure = unsure[rng.random(len(unsure)) < UNSURE_SHARE]
    return np.sort(np.concatenate((unsure, rng.permutation(ground)[:OTHER_GROUND])))


def both(network: Network, samples: PictureSamples, labelled: Rows, rows: Rows, seed: int) -> NDArray[np.float64]:
    """Probabilities (N, 3) of surface, buried and background for `rows`: half the network's, half those of boosting
    that learns from the labelled rows."""
    p = 0.5 * network_says(network, samples, rows) + 0.5 * boosting_says(samples, labelled, rows, seed)
    shares: NDArray[np.float64] = p / p.sum(axis=1, keepdims=True)
    return shares


def network_says(network: Network, samples: PictureSamples, rows: Rows) -> NDArray[np.float32]:
    """Probabilities (N, 3): means over the mirror images."""
    layers = fold(network.weights, network.biases, network.mean, network.scale, 1.0)
    p = np.zeros((len(rows), 3), np.float32)
    for begin in range(0, len(rows), PART):
        vectors = samples.vectors[rows[begin : begin + PART]].astype(np.float32)
        for image in MIRRORED:
            flow = vectors[:, image]
            for weight, bias in layers[:-1]:
                flow = np.maximum(flow @ weight + bias, 0.0)
            said = softmax(flow @ layers[-1][0] + layers[-1][1])
            p[begin : begin + PART, np.array(network.classes) - SURFACE] += said / len(MIRRORED)
    return p


def boosting_says(samples: PictureSamples, labelled: Rows, rows: Rows, seed: int) -> NDArray[np.float64]:
    """Probabilities (N, 3) by boosting that learns from at most MAX_ROWS labelled rows of unaltered pictures."""
    known = (samples.round[labelled] == 0) & np.isin(samples.truth[labelled], (SURFACE, BURIED, BACKGROUND))
    some = np.sort(np.random.default_rng([seed, 87]).permutation(np.sort(labelled[known]))[:MAX_ROWS])
    model = HistGradientBoostingClassifier(max_iter=TREES, max_features=FEATURES, random_state=seed)
    model.fit(samples.vectors[some].astype(np.float32), samples.truth[some])
    p = np.full((len(rows), 3), 1e-6)
    for begin in range(0, len(rows), PART):
        vectors = samples.vectors[rows[begin : begin + PART]].astype(np.float32)
        p[begin : begin + PART, model.classes_ - SURFACE] = model.predict_proba(vectors)
    return p


def taught(told: Told, truth: NDArray[np.integer], rows: Rows, said: NDArray[np.float64]) -> Told:
    """Every row once for each kind that its label or the answers give it.

    told: the labelled samples. truth: of all samples. rows (N,): the labelled and others; said (N, 3): the answers.
    A labelled row keeps its weight. Any other has the mean weight of labelled ground, and all of it by the answers. A
    mine of unknown kind is of the kinds that the answers say.
    """
    index, labels, weights = told
    place = np.full(len(truth), -1)
    place[rows] = np.arange(len(rows))
    share = np.zeros(len(rows))
    np.add.at(share, place[index], weights)
    sure = np.zeros((len(rows), 3))
    sure[place[index], labels - SURFACE] = 1.0
    unknown = truth[rows] == MINE_UNKNOWN
    sure[unknown, :-1] = said[unknown, :-1] / said[unknown, :-1].sum(axis=1, keepdims=True)
    other = share == 0.0
    sure[other] = said[other]
    share[other] = weights[labels == BACKGROUND].mean()
    target = (1.0 - TAUGHT) * sure + TAUGHT * said
    target[target < MIN_PROBABILITY] = 0.0
    target /= target.sum(axis=1, keepdims=True)
    row, kind = np.nonzero(target)
    return rows[row], kind + SURFACE, share[row] * target[row, kind]
