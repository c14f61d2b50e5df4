"""The network's training: 256 and 128 hidden units, weighted samples, a learning rate that falls once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from sklearn.neural_network import MLPClassifier

HIDDEN = (256, 128)
WEIGHT_DECAY = 0.05
RATE, SLOWER, SLOWER_AFTER = 5e-4, 0.2, 0.6
# The same for a network that goes on: what it knows is not to be lost.
GENTLE_RATE = 2.5e-4
BATCH = 512
# Added to every standard deviation: what hardly varies may not be blown up.
LEAST_DEVIATION = 0.02


@dataclass(frozen=True, eq=False)
class Network:
    """Weights and biases of the layers, and what the input is standardised with."""

    weights: list[NDArray[np.floating]]
    biases: list[NDArray[np.floating]]
    mean: NDArray[np.float64]
    scale: NDArray[np.float64]
    classes: tuple[int, ...]

    def logits(self, vectors: NDArray[np.floating]) -> NDArray[np.float32]:
        """(N, len(CLASSES)); a class that was never shown gets -30."""
        flow = ((vectors - self.mean) / self.scale).astype(np.float32)
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            flow = np.maximum(flow @ weight + bias, 0.0)
        answer = np.full((len(vectors), len(CLASSES)), -30.0, np.float32)
        answer[:, self.classes] = flow @ self.weights[-1] + self.biases[-1]
        return answer


def fit(
    vectors: NDArray[np.floating],
    labels: NDArray[np.integer],
    weights: NDArray[np.floating],
    epochs: int,
    seed: int,
    start: Network | None = None,
) -> Network:
    """Trains on vectors (N, LENGTH) with labels (N,) into CLASSES and weights (N,).

    start: a network whose weights are gone on from, where the vectors that it has seen are among these.
    """
    mean, deviation = _moments(vectors)
    scale = deviation + LEAST_DEVIATION
    classes = tuple(np.unique(labels).tolist())
    rng = np.random.default_rng([seed, 84])
    rate = RATE if start is None else GENTLE_RATE
    network = MLPClassifier(HIDDEN, alpha=WEIGHT_DECAY, batch_size=BATCH, learning_rate_init=rate, random_state=seed)
    standard = np.empty(vectors.shape, np.float32)
    for begin in range(0, len(vectors), 4096):
        standard[begin : begin + 4096] = (vectors[begin : begin + 4096] - mean) / scale
    standard = np.clip(standard, -8.0, 8.0, out=standard)
    share = (weights / weights.mean()).astype(np.float32)
    if start is not None:
        _go_on(network, start, mean, scale, standard, labels)
    for epoch in range(epochs):
        if epoch == round(SLOWER_AFTER * epochs):
            optimizer = network._optimizer
            optimizer.learning_rate_init = optimizer.learning_rate = rate * SLOWER
        order = rng.permutation(len(standard))
        network.partial_fit(standard[order], labels[order], classes=classes, sample_weight=share[order])
    return Network(network.coefs_, network.intercepts_, mean, scale, classes)


def _go_on(
    network: MLPClassifier, start: Network, mean: NDArray, scale: NDArray, standard: NDArray, labels: NDArray
) -> None:
    """Takes over the weights of `start`, which expects another standardisation; inputs unknown to it stay random."""
    one_of_each = [int(np.flatnonzero(labels == c)[0]) for c in start.classes]
    network.partial_fit(standard[one_of_each], labels[one_of_each], classes=start.classes)
    known = np.abs(start.weights[0]).max(axis=1) > 0.0
    first = start.weights[0] / start.scale[:, None]
    network.coefs_[0][known] = (first * scale[:, None])[known]
    network.intercepts_[0][:] = start.biases[0] + (mean - start.mean)[known] @ first[known]
    for mine, theirs in zip(network.coefs_[1:], start.weights[1:], strict=True):
        mine[...] = theirs
    for mine, theirs in zip(network.intercepts_[1:], start.biases[1:], strict=True):
        mine[...] = theirs


def _moments(vectors: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and standard deviation of every column, in parts: the vectors may be float16."""
    total, squares = np.zeros(vectors.shape[1]), np.zeros(vectors.shape[1])
    for begin in range(0, len(vectors), 4096):
        part = vectors[begin : begin + 4096].astype(np.float64)
        total, squares = total + part.sum(axis=0), squares + (part * part).sum(axis=0)
    mean = total / len(vectors)
    return mean, np.sqrt(np.maximum(squares / len(vectors) - mean * mean, 0.0))
