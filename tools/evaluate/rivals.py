"""Classifiers to compare with, on the same splits: all see plain 16x16 patches, nothing else."""

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

from tools.train.picture_samples import PictureSamples
from tools.train.records import Record

SIDE = 16


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
    return found / (found.std(axis=1, keepdims=True) + 1.0)


def rivals(seed: int) -> dict[str, ClassifierMixin]:
    """Untrained."""
    return {
        "plain MLP": make_pipeline(StandardScaler(), MLPClassifier((256, 128), max_iter=15, random_state=seed)),
        "SVM": make_pipeline(StandardScaler(), PCA(60, random_state=seed), SVC(C=3.0, class_weight="balanced")),
        "gradient boosting": HistGradientBoostingClassifier(max_iter=40, random_state=seed),
    }
