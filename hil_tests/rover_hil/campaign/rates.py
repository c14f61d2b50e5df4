"""From the rows of a campaign to rates with their bounds, by stratum; nothing is hidden in a mean."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy import stats

from rover_hil.campaign.intervals import binomial_interval, poisson_interval, upper_bound
from rover_hil.campaign.trial import CRASHED, TIMED_OUT

Row = Mapping[str, Any]
NO_END = (CRASHED, TIMED_OUT, "worker lost")

# Missions in which something happened that must not.
EVENTS: dict[str, Callable[[Row], bool]] = {
    "no end": lambda row: row["status"] in NO_END,
    "collision": lambda row: bool(row.get("collisions")),
    "keep-out entry": lambda row: bool(row.get("keepout_violations")),
    "unseen ground": lambda row: bool(row.get("unseen_ground_m2")),
    "wheel over mine": lambda row: bool(row.get("wheel_over_mine")),
    "bumper contact": lambda row: bool(row.get("bumper_contacts")),
    "not done": lambda row: row["status"] != "done",
    "not at home": lambda row: row.get("home") is False,
}
# Outcomes whose dependence on what was drawn is told.
OUTCOMES = ("coverage", "duration_s", "relative_rmse_m", "inside_95", "fresh_wheel_m2", "min_clearance_m")


def failed(row: Row) -> bool:
    """Whether a mission broke an invariant, or came to no end."""
    names = ("no end", "collision", "keep-out entry", "unseen ground", "wheel over mine")
    return any(EVENTS[name](row) for name in names)


def rates(rows: Sequence[Row]) -> dict[str, dict[str, float | int | None]]:
    """count, of, low, high (95 %, exact) and for shares `below`, the one-sided bound; of missions unless named else."""
    found: dict[str, dict[str, float | int | None]] = {}
    driven = [row for row in rows if row["status"] != "refused"]
    for name, happened in EVENTS.items():
        found[name] = _share(sum(map(happened, driven)), len(driven))
    found["refused"] = _share(len(rows) - len(driven), len(rows))
    ended = [row for row in driven if row.get("mines_with_contrast") is not None]
    visible = sum(row["mines_with_contrast"] for row in ended)
    found["mines found of those that show"] = _share(sum(row["mines_with_contrast_found"] for row in ended), visible)
    area = sum(row["area_m2"] for row in ended)
    false = sum(row["mines_false"] for row in ended)
    low, high = poisson_interval(false, area) if area else (0.0, None)
    found["false indications per m²"] = {"count": false, "of": round(area, 2), "low": low, "high": high}
    inside = [row["inside_95"] for row in ended if row["inside_95"] is not None]
    outside = 1.0 - float(np.mean(inside)) if inside else None
    found["position outside its 95 % bound"] = {
        "count": None if outside is None else round(outside * len(inside), 2),
        "of": len(inside),
        **_bootstrap([1.0 - value for value in inside]),
    }
    return found


def by_stratum(rows: Sequence[Row], keys: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Rates of the rows with each value of each key, by "key = value"."""
    found = {}
    for key in keys:
        for value in sorted({repr(row[key]) for row in rows}):
            found[f"{key} = {value}"] = rates([row for row in rows if repr(row[key]) == value])
    return found


def sensitivity(rows: Sequence[Row], keys: Sequence[str]) -> list[dict[str, Any]]:
    """What each outcome owes to each drawn key: rank correlation and its p-value, the strongest first.

    Values that are no numbers are compared as groups (Kruskal-Wallis; the effect is epsilon squared).
    """
    found = []
    for key in keys:
        for outcome in OUTCOMES:
            pairs = [(row[key], row[outcome]) for row in rows if row.get(outcome) is not None]
            if len(pairs) < 8 or len({repr(a) for a, _ in pairs}) < 2 or len({b for _, b in pairs}) < 2:
                continue
            if all(isinstance(value, int | float) and not isinstance(value, bool) for value, _ in pairs):
                told = stats.spearmanr(*zip(*pairs, strict=True))
                effect, p = float(told.statistic), float(told.pvalue)
            else:
                groups: dict[str, list[float]] = {}
                for value, result in pairs:
                    groups.setdefault(repr(value), []).append(result)
                told = stats.kruskal(*groups.values())
                effect, p = float(told.statistic) / (len(pairs) - 1), float(told.pvalue)
            found.append({"key": key, "outcome": outcome, "effect": round(effect, 3), "p": float(f"{p:.3g}")})
    return sorted(found, key=lambda entry: entry["p"])


def worst(rows: Sequence[Row], share: float) -> list[Row]:
    """Failures first, then those with the least coverage and the largest error; at least `share` of all."""

    def badness(row: Row) -> tuple[Any, ...]:
        error = row.get("relative_rmse_m")
        return (not failed(row), row["status"] == "done", row.get("coverage") or 0.0, -(error or 0.0), row["index"])

    ranked = sorted(rows, key=badness)
    return ranked[: max(sum(map(failed, rows)), round(share * len(rows)))]


def against(rows: Sequence[Row], baseline: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Whether this build differs from another that drove the same missions: pairs, exact test of McNemar."""
    former = {(row["index"], row["seed"]): row for row in baseline}
    pairs = [(former[key], row) for row in rows if (key := (row["index"], row["seed"])) in former]
    found = {}
    for name, happened in EVENTS.items():
        gone = sum(happened(before) and not happened(now) for before, now in pairs)
        new = sum(happened(now) and not happened(before) for before, now in pairs)
        p = float(stats.binomtest(new, gone + new).pvalue) if gone + new else 1.0
        found[name] = {"pairs": len(pairs), "gone": gone, "new": new, "p": round(p, 4), "real": p < 0.05}
    return found


def _share(count: int, of: int) -> dict[str, float | int | None]:
    if not of:
        return {"count": count, "of": of, "low": 0.0, "high": 1.0, "below": 1.0}
    low, high = binomial_interval(count, of)
    below = round(upper_bound(count, of), 6)
    return {"count": count, "of": of, "low": round(low, 6), "high": round(high, 6), "below": below}


def _bootstrap(values: Sequence[float]) -> dict[str, float | None]:
    """95 % interval of a mean over missions, each of which is one: its samples depend on each other."""
    if len(values) < 2:
        return {"low": None, "high": None}
    rng = np.random.default_rng(1)
    means = rng.choice(np.asarray(values), (2000, len(values))).mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975)).tolist()
    return {"low": round(low, 4), "high": round(high, 4)}
