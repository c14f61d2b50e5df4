"""Classifiers to compare with, on the same splits and candidates."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from sklearn.base import ClassifierMixin
from sklearn.decomposition import PCA
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC

from tools.evaluate.folds import Judge
from tools.train.measure import softmax
from tools.train.picture.recipe import Learned
from tools.train.picture.records import Record
from tools.train.picture.samples import BACKGROUND, BURIED, SURFACE, PictureSamples

SIDE = 16
PLAIN, BOOSTING = "plain MLP", "gradient boosting"
# Rows that a rival learns from: it would take hours with all.
MAX_ROWS = 4000


def patches(samples: PictureSamples, records: Sequence[Record], rows: NDArray[np.intp]) -> NDArray[np.float32]:
    """16x16 grey patches (N, 256) of spots on pictures as they lie on disk, each brought to mean 0 and deviation 1."""
    found = np.zeros((len(rows), SIDE * SIDE), np.float32)
    for i, row in enumerate(rows.tolist()):
        grey = records[samples.picture[row]].grey
        x, y, extent = samples.spots[row].tolist()
        low_x, low_y = max(0, round(x - extent / 2)), max(0, round(y - extent / 2))
        part = grey[low_y : max(low_y + 1, round(y + extent / 2)), low_x : max(low_x + 1, round(x + extent / 2))]
        found[i] = cv2.resize(part.astype(np.float32), (SIDE, SIDE), interpolation=cv2.INTER_AREA).ravel()
    found -= found.mean(axis=1, keepdims=True)
    even: NDArray[np.float32] = found / (found.std(axis=1, keepdims=True) + 1.0)
    return even


def rivals(seed: int) -> dict[str, ClassifierMixin]:
    """Untrained; all but the first see the numbers that the network sees."""
    return {
        PLAIN: make_pipeline(StandardScaler(), MLPClassifier((256, 128), max_iter=15, random_state=seed)),
        "SVM": make_pipeline(StandardScaler(), PCA(60, random_state=seed), SVC(C=3.0, class_weight="balanced")),
        BOOSTING: HistGradientBoostingClassifier(max_iter=60, max_features=0.2, random_state=seed),
    }


def rival_judge(
    name: str, model: ClassifierMixin, samples: PictureSamples, records: Sequence[Record], learned: Learned, seed: int
) -> Judge:
    """Trains the rival on rows of unaltered pictures that the network has learned from too, at most MAX_ROWS."""
    rows = np.union1d(learned.mines, learned.ground)
    rows = rows[(samples.round[rows] == 0) & np.isin(samples.truth[rows], (SURFACE, BURIED, BACKGROUND))]
    rows = np.sort(np.random.default_rng([seed, 87]).permutation(rows)[:MAX_ROWS])

    def shown(some: NDArray[np.intp]) -> NDArray[np.float32]:
        return patches(samples, records, some) if name == PLAIN else samples.vectors[some].astype(np.float32)

    model.fit(shown(rows), samples.truth[rows])

    def judge(some: NDArray[np.intp]) -> NDArray[np.floating]:
        p = np.zeros((len(some), 3))
        if len(some):
            seen = shown(some)
            told = hasattr(model, "predict_proba")
            scores = model.predict_proba(seen) if told else softmax(_margins(model.decision_function(seen)))
            p[:, [c - SURFACE for c in model.classes_]] = scores
        return p

    return judge


def _margins(scores: NDArray[np.floating]) -> NDArray[np.floating]:
    """(N, classes) also where two classes have one margin between them."""
    return scores if scores.ndim == 2 else np.column_stack((-scores, scores))
