"""How good the answers are: confusion, recall per class, and whether probabilities mean what they say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES

BINS = 10


def confusion(labels: NDArray[np.int64], p: NDArray[np.floating]) -> NDArray[np.int64]:
    """Counts (classes, classes): rows are the truth, columns the most probable class."""
    table = np.zeros((len(CLASSES),) * 2, np.int64)
    np.add.at(table, (labels, p.argmax(axis=1)), 1)
    return table


def calibration_error(labels: NDArray[np.int64], p: NDArray[np.floating]) -> float:
    """Expected calibration error of the most probable class, over BINS equal bins of its probability."""
    top, right = p.max(axis=1), p.argmax(axis=1) == labels
    place = np.minimum((top * BINS).astype(int), BINS - 1)
    return float(sum(abs(float((right - top)[place == b].sum())) for b in range(BINS)) / max(len(labels), 1))


def fit_temperature(labels: NDArray[np.int64], logits: NDArray[np.floating]) -> float:
    """The temperature in [0.5, 5] that makes the labels most likely."""
    grid = np.geomspace(0.5, 5.0, 60)
    return float(grid[np.argmin([_negative_log_likelihood(labels, logits / t) for t in grid])])


def fit_pictures(
    labels: NDArray[np.int64], logits: NDArray[np.floating], ground: int
) -> tuple[float, NDArray[np.float32]]:
    """Factor of the logits and offset of the class `ground` that make the labels most likely; a coarse grid twice."""
    best = (np.inf, 1.0, 0.0)
    factors, offsets = np.geomspace(0.2, 1.5, 14), np.linspace(-3.0, 8.0, 23)
    for _ in range(2):
        for factor in factors:
            for offset in offsets:
                shifted = logits * factor
                shifted[:, ground] += offset
                best = min(best, (_negative_log_likelihood(labels, shifted), float(factor), float(offset)))
        factors, offsets = best[1] * np.geomspace(0.9, 1.1, 7), best[2] + np.linspace(-0.5, 0.5, 9)
    shift = np.zeros(logits.shape[1], np.float32)
    shift[ground] = best[2]
    return best[1], shift


def softmax(logits: NDArray[np.floating]) -> NDArray[np.floating]:
    """Probabilities (N, classes)."""
    e = np.exp(logits - logits.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)


def _negative_log_likelihood(labels: NDArray[np.int64], logits: NDArray[np.floating]) -> float:
    return -float(np.log(softmax(logits)[np.arange(len(labels)), labels] + 1e-12).mean())


def mine_share(labels: NDArray[np.int64], p: NDArray[np.floating], threshold: float = 0.5) -> tuple[float, float]:
    """Share of mines whose two mine classes together reach the threshold, and the same share of all else."""
    mine_columns = [CLASSES.index("surface"), CLASSES.index("buried")]
    called = p[:, mine_columns].sum(axis=1) >= threshold
    truth = np.isin(labels, mine_columns)
    return float(called[truth].mean()) if truth.any() else 0.0, float(called[~truth].mean()) if (~truth).any() else 0.0


def as_markdown(labels: NDArray[np.int64], p: NDArray[np.floating]) -> str:
    """The confusion as a table, then the shares."""
    lines = ["| truth \\ answer | " + " | ".join(CLASSES) + " |", "|---" * (len(CLASSES) + 1) + "|"]
    lines += [
        f"| {name} | " + " | ".join(str(n) for n in row) + " |"
        for name, row in zip(CLASSES, confusion(labels, p), strict=True)
    ]
    found, false = mine_share(labels, p)
    lines.append("")
    lines.append(
        f"Mines called mines {found:.1%}, other candidates called mines {false:.1%}, "
        f"expected calibration error {calibration_error(labels, p):.3f}."
    )
    return "\n".join(lines)
