"""The network's training: 256 and 128 hidden units, weighted samples, a learning rate that falls."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from sklearn.neural_network import MLPClassifier

HIDDEN = (256, 128)
WEIGHT_DECAY = 0.05
BATCH = 512
# Samples of an epoch are varied in so many parts, so that no second copy of all of them is needed.
PARTS = 8
# Added to every standard deviation: what hardly varies may not be blown up.
MIN_DEVIATION = 0.02


# Vectors and labels to other vectors of the same candidates; may change the vectors in place.
Vary = Callable[[NDArray[np.float32], NDArray[np.integer], np.random.Generator], NDArray[np.float32]]


def fall_once(done: float) -> float:
    """Learning rate after the share `done` of all epochs: lower for the last of them."""
    return 5e-4 if done < 0.6 else 1e-4


def fall_smoothly(done: float) -> float:
    """Learning rate after the share `done` of all epochs: half a cosine down to a fiftieth."""
    return 1e-3 * (0.02 + 0.49 * (1.0 + math.cos(math.pi * done)))


# Weights (in, out) and biases (out,).
Layer = tuple[NDArray[np.float32], NDArray[np.float32]]


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

    def every_class(self, layers: list[Layer]) -> list[Layer]:
        """The layers with an answer for each of CLASSES; one that was never shown gets -30."""
        weight, bias = layers[-1]
        wide, level = np.zeros((len(weight), len(CLASSES)), np.float32), np.full(len(CLASSES), -30.0, np.float32)
        wide[:, self.classes], level[list(self.classes)] = weight, bias
        return [*layers[:-1], (wide, level)]


def fit(
    vectors: NDArray[np.floating],
    labels: NDArray[np.integer],
    weights: NDArray[np.floating],
    epochs: int,
    seed: int,
    rate: Callable[[float], float] = fall_once,
    vary: Vary | None = None,
    averaged: float = 0.0,
) -> Network:
    """Trains on vectors (N, length) with labels (N,) into CLASSES and weights (N,).

    rate: the learning rate by the share of epochs that is done. vary: what is done to the standardised vectors anew
    in each epoch. averaged: share of the steps, the last ones, whose weights' mean is the network; 0: the last weights.
    """
    mean, deviation = _moments(vectors)
    scale = deviation + MIN_DEVIATION
    classes = tuple(np.unique(labels).tolist())
    rng = np.random.default_rng([seed, 84])
    network = MLPClassifier(
        HIDDEN, alpha=WEIGHT_DECAY, batch_size=BATCH, learning_rate_init=rate(0.0), random_state=seed
    )
    standard = np.empty(vectors.shape, np.float32)
    for begin in range(0, len(vectors), 4096):
        standard[begin : begin + 4096] = (vectors[begin : begin + 4096] - mean) / scale
    standard = np.clip(standard, -8.0, 8.0, out=standard)
    share = (weights / weights.mean()).astype(np.float32)
    parts = PARTS if vary else 1
    mean_layers, count = None, 0
    for epoch in range(epochs):
        if epoch:
            optimizer = network._optimizer
            optimizer.learning_rate_init = optimizer.learning_rate = rate(epoch / epochs)
        for number, part in enumerate(np.array_split(rng.permutation(len(standard)), parts)):
            some = standard[part] if vary is None else vary(standard[part], labels[part], rng)
            network.partial_fit(some, labels[part], classes=classes, sample_weight=share[part])
            if epoch * parts + number >= (1.0 - averaged) * epochs * parts:
                layers, count = [*network.coefs_, *network.intercepts_], count + 1
                before = mean_layers or [np.zeros(layer.shape) for layer in layers]
                mean_layers = [old + (new - old) / count for old, new in zip(before, layers, strict=True)]
    if mean_layers is None:
        return Network(network.coefs_, network.intercepts_, mean, scale, classes)
    depth = len(network.coefs_)
    return Network(mean_layers[:depth], mean_layers[depth:], mean, scale, classes)


def _moments(vectors: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and standard deviation of every column, in parts: the vectors may be float16."""
    total, squares = np.zeros(vectors.shape[1]), np.zeros(vectors.shape[1])
    for begin in range(0, len(vectors), 4096):
        part = vectors[begin : begin + 4096].astype(np.float64)
        total, squares = total + part.sum(axis=0), squares + (part * part).sum(axis=0)
    mean = total / len(vectors)
    return mean, np.sqrt(np.maximum(squares / len(vectors) - mean * mean, 0.0))
