"""Registration on real pictures, beside plain OpenCV."""

from __future__ import annotations

import itertools
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.vision.registration.cluster import NOISE, dbscan
from rover.vision.registration.features import Features
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.matching import match_features
from rover.vision.registration.register import RegistrationSettings, find_features, prepare, register, register_prepared

from tools.bench.vision.plain import plain_features, plain_homography
from tools.bench.vision.truth import Points, facade, graf, landmines


def corner_error(homography: Points | None, truth: Points, shape: tuple[int, ...]) -> float:
    """Mean distance in pixels between where both put the corners of picture A; infinite without a homography."""
    if homography is None:
        return float("inf")
    height, width = shape[:2]
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    apart = apply_homography(homography, corners) - apply_homography(truth, corners)
    return float(np.linalg.norm(apart, axis=1).mean())


def graf_table(data: Path) -> str:
    """Corner errors against the published homographies: as `register`, with plain RANSAC in it, and plain OpenCV."""
    pictures, truths = graf(data)
    lines = ["| graf | corner error, px | with RANSAC for USAC_MAGSAC | plain ORB + RANSAC | inliers | equation 6 "
             "before → after, px | time, ms |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    for number, (picture, truth) in enumerate(zip(pictures[1:], truths, strict=True), start=2):
        begin = time.thread_time()
        found = register(pictures[0], picture)
        spent = (time.thread_time() - begin) * 1e3
        ours = corner_error(found.homography, truth, pictures[0].shape)
        plain = corner_error(
            plain_homography(plain_features(pictures[0]), plain_features(picture)), truth, pictures[0].shape
        )
        told = f"{ours:.2f}" if found.homography is not None else f"refused: {found.reason}"
        other = register(pictures[0], picture, RegistrationSettings(estimator="ransac"))
        simple = corner_error(other.homography, truth, pictures[0].shape)
        beside = f"{simple:.2f}" if other.homography is not None else f"refused: {other.reason}"
        before = f"{found.rmse_before:.1f} → {found.rmse_after:.2f}" if found.rmse_before is not None else "–"
        lines.append(f"| 1→{number} | {told} | {beside} | {plain:.1f} | {found.inliers} | {before} | {spent:.0f} |")
    return "\n".join(lines)


def unrelated_table(data: Path, count: int, seed: int) -> str:
    """Pairs that show different things, or are shuffled: how many are accepted?"""
    settings, rng = RegistrationSettings(), np.random.default_rng(seed)
    mined = landmines(data)
    by_zone: dict[str, list[str]] = {}
    for name in mined:
        by_zone.setdefault(name.split("_")[0], []).append(name)
    groups = {zone: sorted(rng.choice(names, 5, replace=False).tolist()) for zone, names in sorted(by_zone.items())}
    items = [(zone, name, mined[name]) for zone, names in groups.items() for name in names]
    wall = facade(data)
    items += [("dunr", f"dunr {k}", wall.pictures[k]) for k in range(0, 26, 6)]
    items += [("graf", f"graf {k + 1}", picture) for k, picture in enumerate(graf(data)[0])]
    ready = {name: prepare(picture, settings) for _, name, picture in items}
    pairs = [(a, b) for (at_a, a, _), (at_b, b, _) in itertools.combinations(items, 2) if at_a != at_b]
    chosen = [pairs[k] for k in sorted(rng.permutation(len(pairs))[:count].tolist())]
    accepted = [
        f"{a} and {b}" for a, b in chosen if register_prepared(ready[a], ready[b], settings).homography is not None
    ]
    simple = {name: plain_features(picture) for _, name, picture in items}
    plain = sum(plain_homography(simple[a], simple[b]) is not None for a, b in chosen)
    return "\n".join(
        [
            "| unrelated pairs | accepted by `rover register` | a homography from plain ORB + RANSAC |",
            "|---|---|---|",
            f"| {len(chosen)} | {len(accepted)}{': ' + ', '.join(accepted) if accepted else ''} | {plain} |",
        ]
    )


def cluster_table(data: Path) -> str:
    """DBSCAN by position as in the paper, in position and displacement, and none: matches kept, and how many right."""
    pictures, truths = graf(data)
    settings = RegistrationSettings()
    wall = facade(data)
    pairs = [(pictures[0], p, t) for p, t in zip(pictures[1:], truths, strict=True)]
    for a, b in itertools.pairwise(wall.pictures):
        found = register(a, b, settings)
        if found.homography is not None:
            pairs.append((a, b, found.homography))
    features: dict[int, Features] = {}
    kinds = ("none", "position, 20 px", "position and displacement, 20 px", "position and displacement, 40 px")
    sums = {kind: np.zeros((2, 3)) for kind in kinds}
    for number, (a, b, truth) in enumerate(pairs):
        for picture in (a, b):
            if id(picture) not in features:
                features[id(picture)] = find_features(picture, settings)
        in_a, in_b = match_features(features[id(a)], features[id(b)], settings.match)
        here, there = features[id(a)].points[in_a], features[id(b)].points[in_b]
        right = np.linalg.norm(apply_homography(truth, here) - there, axis=1) <= settings.inlier_px
        for kind in kinds:
            kept = _kept(kind, here, there)
            sums[kind][min(1, number // 3)] += (kept.sum(), (kept & right).sum(), right.sum())
    lines = ["| DBSCAN, minPts = 5 | graf: matches kept | right | right ones lost | dunr: matches kept | right | "
             "right ones lost |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    for kind in kinds:
        cells = [f"{k:.0f} | {r / k:.1%} | {1.0 - r / t:.1%}" for k, r, t in sums[kind].tolist()]
        lines.append(f"| {kind} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _kept(kind: str, here: Points, there: Points) -> NDArray[np.bool_]:
    if kind == "none":
        return np.ones(len(here), dtype=bool)
    epsilon = 40.0 if kind.endswith("40 px") else 20.0
    if kind.startswith("position and"):
        return np.asarray(dbscan(np.column_stack((here, there - here)), epsilon) != NOISE)
    return np.asarray((dbscan(here, epsilon) != NOISE) & (dbscan(there, epsilon) != NOISE))
