"""Matching binary descriptors: all Hamming distances at once, mutual best, and a test against the runner-up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.features import Features

BITS = 256

_SIGNS = (np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).astype(np.float32) * 2.0) - 1.0

FAR = np.float32(4.0 * BITS)


@dataclass(frozen=True)
class MatchSettings:
    """max_distance: bits that may differ. ratio: best distance over the second best must not exceed it."""

    max_distance: float = 72.0
    ratio: float = 0.9


def signs(descriptors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Descriptors (N, 32) as (N, 256) of -1 and +1: their product tells how many bits agree, exactly."""
    found: NDArray[np.float32] = _SIGNS[descriptors].reshape(len(descriptors), BITS)
    return found


def hamming(descriptors_a: NDArray[np.uint8], descriptors_b: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Hamming distances (N, M) of descriptors (N, 32) and (M, 32)."""
    if not hasattr(np, "bitwise_count"):  # NumPy 1
        return hamming_by_product(signs(descriptors_a), signs(descriptors_b))
    words_a, words_b = (np.ascontiguousarray(d).view(np.uint64).T.copy() for d in (descriptors_a, descriptors_b))
    total = np.zeros((len(descriptors_a), len(descriptors_b)), np.uint16)
    for a, b in zip(words_a, words_b, strict=True):
        total += np.bitwise_count(a[:, None] ^ b[None, :])
    return total.astype(np.float32)


def hamming_by_product(signs_a: NDArray[np.float32], signs_b: NDArray[np.float32]) -> NDArray[np.float32]:
    """Hamming distances (N, M) of two sets of `signs`; integers below 2^24, so float32 is exact."""
    distances: NDArray[np.float32] = (np.float32(BITS) - signs_a @ signs_b.T) * np.float32(0.5)
    return distances


def mutual_matches(
    distances: NDArray[np.float32], allowed: NDArray[np.bool_] | None, settings: MatchSettings
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs (rows, columns) of `distances` (N, M) that are each other's best and pass distance and ratio.

    allowed: (N, M), pairs that may match at all; others don't count as runners-up either.
    """
    if distances.shape[0] == 0 or distances.shape[1] == 0:
        return np.empty(0, np.intp), np.empty(0, np.intp)
    if allowed is not None:
        distances = np.where(allowed, distances, FAR)
    rows = np.arange(distances.shape[0])
    best = distances.argmin(axis=1)
    value = distances[rows, best]
    mutual = (distances.argmin(axis=0)[best] == rows) & (value <= settings.max_distance)
    rows, best, value = rows[mutual], best[mutual], value[mutual]
    if distances.shape[1] > 1 and settings.ratio < 1.0:
        others = distances[rows]
        others[np.arange(len(rows)), best] = np.inf
        second = others.min(axis=1)
        distinct = value <= settings.ratio * second
        rows, best = rows[distinct], best[distinct]
    return rows, best


Matches = tuple[NDArray[np.intp], NDArray[np.intp]]


def match_features(a: Features, b: Features, settings: MatchSettings) -> Matches:
    """Indices into `a` and `b` of the features that match, each other's best."""
    return mutual_matches(hamming(a.descriptors, b.descriptors), None, settings)


def match_both_ways(distances: NDArray[np.float32], settings: MatchSettings) -> tuple[Matches, Matches]:
    """`mutual_matches` of A and B, and of B and A, from the same distances (N, M); each way has its own runners-up."""
    return mutual_matches(distances, None, settings), mutual_matches(distances.T.copy(), None, settings)
