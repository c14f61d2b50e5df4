"""Intervals for rates over pictures. Pictures of one flight show one object on one ground under one sky: it is flights
that are drawn again, not pictures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tools.train.picture.records import Record

ROUNDS = 4000


def flights(records: Sequence[Record]) -> NDArray[np.intp]:
    """Number of each record's flight: all pictures of one zone in one session."""
    names = [f"{record.zone}{record.session}" for record in records]
    _, number = np.unique(names, return_inverse=True)
    return np.asarray(number, np.intp)


def rate(
    counts: NDArray[np.floating], exposure: NDArray[np.floating], flight: NDArray[np.intp], others: bool = False
) -> tuple[float, ...]:
    """Sum of `counts` (N,) over that of `exposure` (N,), and its 95 % interval: whole flights drawn again.

    others: where the rate of as many other flights lies, which differ by chance as the flights of this one do.
    """
    _, own = np.unique(flight, return_inverse=True)
    above, below = (np.bincount(own, part) for part in (counts, exposure))
    drawn = np.random.default_rng(91).integers(0, len(above), (2, ROUNDS, len(above)))
    shares, of_others = above[drawn].sum(axis=2) / np.maximum(below[drawn].sum(axis=2), 1e-9)
    value = float(above.sum() / max(below.sum(), 1e-9))
    if others:
        shares = np.maximum(value + shares - of_others, 0.0)
    return value, *np.percentile(shares, (2.5, 97.5)).tolist()


def told(figures: tuple[float, ...], digits: int = 2) -> str:
    """A rate with its interval."""
    value, low, high = (f"{figure:.{digits}f}" for figure in figures)
    return f"{value} [{low}, {high}]"
