"""Exact intervals of what was counted."""

from __future__ import annotations

from scipy import stats


def binomial_interval(hits: int, trials: int) -> tuple[float, float]:
    """Exact 95 % interval of a share (Clopper and Pearson)."""
    low = float(stats.beta.ppf(0.025, hits, trials - hits + 1)) if hits else 0.0
    high = float(stats.beta.ppf(0.975, hits + 1, trials - hits)) if hits < trials else 1.0
    return low, high


def upper_bound(hits: int, trials: int) -> float:
    """What a share is below with 95 % confidence, one-sided."""
    return float(stats.beta.ppf(0.95, hits + 1, trials - hits)) if hits < trials else 1.0


def poisson_interval(events: int, exposure: float) -> tuple[float, float]:
    """Exact 95 % interval of a rate per unit of `exposure` (Garwood)."""
    low = float(stats.chi2.ppf(0.025, 2 * events)) / 2 if events else 0.0
    high = float(stats.chi2.ppf(0.975, 2 * (events + 1))) / 2
    return low / exposure, high / exposure
