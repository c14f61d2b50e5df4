"""Registration on real pictures, beside plain OpenCV."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.vision.camera_pose import CameraPose
from rover.vision.cluster import NOISE, dbscan
from rover.vision.features import Features
from rover.vision.homography import apply_homography
from rover.vision.matching import match_features
from rover.vision.preprocess import local_contrast
from rover.vision.registration import RegistrationSettings, find_features, prepare, register, register_prepared
from rover.vision.sequence import SequenceSettings, track_sequence

from tools.bench.vision.plain import plain_features, plain_homography
from tools.bench.vision.truth import WIRIS, Facade, Picture, Points, facade, graf, landmines


def corner_error(homography: Points | None, truth: Points, shape: tuple[int, ...]) -> float:
    """Mean distance in pixels between where both put the corners of picture A; infinite without a homography."""
    if homography is None:
        return float("inf")
    height, width = shape[:2]
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    apart = apply_homography(homography, corners) - apply_homography(truth, corners)
    return float(np.linalg.norm(apart, axis=1).mean())


def graf_table(data: Path) -> str:
    """Corner errors against the published homographies."""
    pictures, truths = graf(data)
    lines = ["| graf | corner error, px | plain ORB + RANSAC | inliers | equation 6 before → after, px | time, ms |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    for number, (picture, truth) in enumerate(zip(pictures[1:], truths, strict=True), start=2):
        begin = time.thread_time()
        found = register(pictures[0], picture)
        spent = (time.thread_time() - begin) * 1e3
        ours = corner_error(found.homography, truth, pictures[0].shape)
        plain = corner_error(
            plain_homography(plain_features(pictures[0]), plain_features(picture)), truth, pictures[0].shape
        )
        told = f"{ours:.2f}" if found.homography is not None else f"refused: {found.reason}"
        before = f"{found.rmse_before:.1f} → {found.rmse_after:.2f}" if found.rmse_before is not None else "–"
        lines.append(f"| 1→{number} | {told} | {plain:.1f} | {found.inliers} | {before} | {spent:.0f} |")
    return "\n".join(lines)


def facade_table(data: Path) -> str:
    """Consecutive pairs of dunr: registered, marker transfer, equation 6; then the track against the survey."""
    wall, settings = facade(data), RegistrationSettings()
    every = [prepare(picture, settings) for picture in wall.pictures]
    results = [register_prepared(a, b, settings) for a, b in itertools.pairwise(every)]
    plain = [plain_homography(a, b) for a, b in itertools.pairwise(map(plain_features, wall.pictures))]
    lines = ["| dunr, 25 consecutive pairs | registered | marker transfer, px: median | 90 % |", "|---|---|---|---|"]
    for name, found in (("rover register", [r.homography for r in results]), ("plain ORB + RANSAC", plain)):
        apart = _transfer(wall, found)
        count = sum(h is not None for h in found)
        lines.append(f"| {name} | {count} | {np.median(apart):.2f} | {np.percentile(apart, 90):.1f} |")
    before = np.median([r.rmse_before for r in results if r.rmse_before is not None])
    after = np.median([r.rmse_after for r in results if r.rmse_after is not None])
    turned, aside, tracked = _track_errors(wall)
    lines += [
        "",
        f"Equation 6 over these pairs: {before:.1f} px before, {after:.2f} px after (median); the paper: 65.7, 63.2.",
        "",
        f"`rover track`: {tracked} of {len(wall.pictures)} frames; relative rotation off by {np.median(turned):.2f}°, "
        f"direction of translation by {np.median(aside):.2f}° (medians over consecutive frames).",
    ]
    return "\n".join(lines)


def _transfer(wall: Facade, homographies: Sequence[Points | None]) -> list[float]:
    apart: list[float] = []
    for k, homography in enumerate(homographies):
        both = sorted(set(wall.markers[k]) & set(wall.markers[k + 1]))
        if homography is None or not both:
            continue
        here, there = (np.array([wall.markers[j][marker] for marker in both]) for j in (k, k + 1))
        apart += np.linalg.norm(apply_homography(homography, here) - there, axis=1).tolist()
    return apart


def _track_errors(wall: Facade) -> tuple[list[float], list[float], int]:
    found: list[CameraPose] = track_sequence(wall.pictures, WIRIS, SequenceSettings())
    turned, aside = [], []
    for a, b in itertools.pairwise(found):
        step = np.linalg.inv(wall.poses[a.frame]) @ wall.poses[b.frame]
        off = (a.rotation.T @ b.rotation).T @ step[:3, :3]
        turned.append(float(np.degrees(np.arccos(np.clip((np.trace(off) - 1.0) / 2.0, -1.0, 1.0)))))
        shift = a.rotation.T @ (b.position - a.position)
        cosine = shift @ step[:3, 3] / (np.linalg.norm(shift) * np.linalg.norm(step[:3, 3]))
        aside.append(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    return turned, aside, len(found)


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
        return dbscan(np.column_stack((here, there - here)), epsilon) != NOISE
    return (dbscan(here, epsilon) != NOISE) & (dbscan(there, epsilon) != NOISE)


def neighbours_table(data: Path, every: int) -> str:
    """Neighbouring pictures of one session of landmines: which are registered, as a list to be checked by eye."""
    settings = RegistrationSettings()
    mined = landmines(data)
    names = list(mined)
    follows = [
        (a, b)
        for a, b in itertools.pairwise(names)
        if a.rsplit("_", 1)[0] == b.rsplit("_", 1)[0] and int(b[-4:]) == int(a[-4:]) + 1
    ][::every]
    found = []
    for a, b in follows:
        made = register(mined[a], mined[b], settings)
        if made.homography is not None:
            found.append((a, b, made))
    lines = [f"{len(found)} of {len(follows)} pairs of consecutive pictures registered:", "",
             "| A | B | inliers | equation 6, px |", "|---|---|---|---|"]  # fmt: skip
    lines += [
        f"| {a} | {b} | {made.inliers} | {made.rmse_before:.1f} → {made.rmse_after:.2f} |" for a, b, made in found
    ]
    return "\n".join(lines)


def chessboard(a: Picture, b: Picture, homography: Points, tiles: int = 8) -> NDArray[np.uint8]:
    """B and, in every second tile, A laid on it: edges that run on across tiles show that the homography is right."""
    height, width = b.shape[:2]
    laid = cv2.warpPerspective(local_contrast(a), homography, (width, height))
    v, u = np.mgrid[0:height, 0:width]
    mixed = local_contrast(b)
    from_a = ((u * tiles // width + v * tiles // height) % 2 == 0) & (laid > 0)
    mixed[from_a] = laid[from_a]
    return mixed
