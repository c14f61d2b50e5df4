"""What each preprocessing step is worth: inliers of registered pairs with the step and without it."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
from rover.capture import open_source
from rover.vision.registration.preprocess import PreprocessSettings
from rover.vision.registration.register import RegistrationSettings, find_features, register_features

from tools.bench.vision.truth import Picture, facade, landmines

EVERYTHING = PreprocessSettings(
    fixed_pattern=True, dead_pixels=True, gaussian_sigma=0.7, percentiles=(1.0, 99.0), clahe_clip=2.0
)
VARIANTS = {
    "all steps": EVERYTHING,
    "without rows and columns": replace(EVERYTHING, fixed_pattern=False),
    "without dead pixels": replace(EVERYTHING, dead_pixels=False),
    "without Gaussian": replace(EVERYTHING, gaussian_sigma=0.0),
    "stretch minimum to maximum": replace(EVERYTHING, percentiles=(0.0, 100.0)),
    "without CLAHE": replace(EVERYTHING, clahe_clip=0.0),
    "stretch alone": PreprocessSettings(False, False, 0.0, clahe_clip=0.0),
    "as `rover register`": RegistrationSettings().preprocess,
}
# Frames between the two of a pair: neighbours of a 9 Hz clip hardly differ.
LEPTON_APART = 3


def pairs_of(data: Path) -> dict[str, list[tuple[Picture, Picture]]]:
    """Pairs that overlap, by set."""
    clip = [frame.counts for frame in open_source(f"cptv:{data / 'lepton/v2.cptv'}") if not frame.ffc]
    wall = facade(data).pictures
    mined = landmines(data)
    beside = [(a, b) for a, b in itertools.pairwise(mined) if a[:7] == b[:7] and int(b[-4:]) == int(a[-4:]) + 1]
    return {
        "lepton": list(zip(clip[::6], clip[LEPTON_APART::6], strict=False)),
        "dunr": list(itertools.pairwise(wall)),
        "landmines": [(mined[a], mined[b]) for a, b in beside[::8]],
    }


def preparation_table(data: Path) -> str:
    """Sum of inliers and number of registered pairs, step by step."""
    sets = pairs_of(data)
    lines = ["| | " + " | ".join(f"{name}: inliers (pairs registered of {len(p)})" for name, p in sets.items()) + " |",
             "|---|" + "---|" * len(sets)]  # fmt: skip
    for name, preprocess in VARIANTS.items():
        cells = []
        for pairs in sets.values():
            settings = replace(RegistrationSettings(), preprocess=preprocess)
            inliers = np.array([_inliers(a, b, settings) for a, b in pairs])
            cells.append(f"{int(inliers.sum())} ({int((inliers > 0).sum())})")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _inliers(a: Picture, b: Picture, settings: RegistrationSettings) -> int:
    found = register_features(find_features(a, settings), find_features(b, settings), a.shape, b.shape, settings)
    return found.inliers if found.homography is not None else 0
