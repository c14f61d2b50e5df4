"""How good the answers are: confusion and F1 per class, and whether probabilities mean what they say."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES, MINES

from tools.train.ground.samples import BACKGROUND, OBSTACLE, UNSURE, Looks

BINS = 10
MINE_COLUMNS = [CLASSES.index(name) for name in MINES]


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
    p: NDArray[np.floating] = e / e.sum(axis=1, keepdims=True)
    return p


def _negative_log_likelihood(labels: NDArray[np.int64], logits: NDArray[np.floating]) -> float:
    return -float(np.log(softmax(logits)[np.arange(len(labels)), labels] + 1e-12).mean())


def confusion_by_look(looks: Looks, p: NDArray[np.floating], floor: float) -> NDArray[np.int64]:
    """Counts (fields, classes, classes) of single looks: rows are the truth, columns the answer.

    A mine of at least `floor` kelvin counts once for each look that it is in view of, with the answer of the most
    mine-like candidate in its halo; without a candidate it is called background. Obstacles and ground count by
    candidates; what lies between two classes, or on a weaker mine, does not count.
    """
    answer, likeness = p.argmax(axis=1), p[:, MINE_COLUMNS].sum(axis=1)
    fields, inverse = np.unique(looks.field, return_inverse=True)
    field_of = np.asarray(inverse, np.intp)
    table = np.zeros((len(fields), len(CLASSES), len(CLASSES)), np.int64)
    for truth, some in ((OBSTACLE, looks.on_obstacle), (BACKGROUND, looks.on_ground)):
        np.add.at(table, (field_of[looks.look[some]], np.intp(truth), answer[some]), 1)
    best: dict[tuple[int, int], int] = {}
    for index in np.flatnonzero(looks.on_mine).tolist():
        key = int(looks.look[index]), int(looks.mine[index])
        if key not in best or likeness[index] > likeness[best[key]]:
            best[key] = index
    for look, mine, kind, contrast in looks.seen.tolist():
        if contrast >= floor:
            index = best.get((int(look), int(mine)))
            table[field_of[int(look)], int(kind), BACKGROUND if index is None else answer[index]] += 1
    return table


def f1_scores(table: NDArray[np.integer]) -> NDArray[np.float64]:
    """F1 per class of counts (..., classes, classes)."""
    right = np.einsum("...ii->...i", table)
    scores: NDArray[np.float64] = 2.0 * right / np.maximum(table.sum(axis=-1) + table.sum(axis=-2), 1)
    return scores


def f1_intervals(by_field: NDArray[np.integer], rounds: int = 1000) -> NDArray[np.float64]:
    """95 % intervals of F1 (classes, 2): whole fields are drawn again with replacement, looks at one are alike."""
    rng = np.random.default_rng(90)
    drawn = rng.integers(0, len(by_field), (rounds, len(by_field)))
    scores = np.stack([f1_scores(by_field[some].sum(axis=0)) for some in drawn])
    return np.asarray(np.percentile(scores, (2.5, 97.5), axis=0).T)


def looks_as_markdown(looks: Looks, p: NDArray[np.floating], floor: float) -> str:
    """Confusion of single looks with F1 and its interval per class, then how sure the probabilities are."""
    by_field = confusion_by_look(looks, p, floor)
    table, intervals = by_field.sum(axis=0), f1_intervals(by_field)
    lines = ["| truth \\ answer | " + " | ".join(CLASSES) + " | F1 |", "|---" * (len(CLASSES) + 2) + "|"]
    for name, row, f1, (low, high) in zip(CLASSES, table, f1_scores(table), intervals, strict=True):
        lines.append(f"| {name} | " + " | ".join(str(n) for n in row) + f" | {f1:.3f} [{low:.3f}, {high:.3f}] |")
    labels = looks.labels(floor)
    sure = labels != UNSURE
    error = calibration_error(labels[sure], p[sure])
    likely = sure & (p[:, MINE_COLUMNS].sum(axis=1) >= 0.1)
    among = calibration_error(labels[likely], p[likely])
    return "\n".join(
        (
            *lines,
            "",
            f"{len(by_field)} fields, {len(looks.field)} looks. Expected calibration error {error:.3f} over all\n"
            f"candidates, {among:.3f} over the {likely.sum()} where a mine has at least 0.1.",
        )
    )


def by_contrast(looks: Looks, p: NDArray[np.floating]) -> str:
    """Buried mines called buried, by their contrast at the surface."""
    steps = (0.25, 0.5, 0.65, 0.8, 1.0, 1.25, 1.6, 2.5, np.inf)
    buried = CLASSES.index("buried")
    lines = ["| contrast at the surface, K | buried mines in view | called buried |", "|---|---|---|"]
    for low, high in pairwise(steps):
        counts = confusion_by_look(looks, p, low)[:, buried] - confusion_by_look(looks, p, high)[:, buried]
        total = int(counts.sum())
        share = f"{counts[:, buried].sum() / total:.2f}" if total else "–"
        lines.append(f"| {low:g} to {high:g} | {total} | {share} |")
    return "\n".join(lines)
