"""`rover register` beside OpenCV's AKAZE, SIFT and ORB: real pairs with a known truth, and synthetic ones."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import read_picture
from rover.vision.registration.register import register

from tools.bench.vision.facade import marker_transfer
from tools.bench.vision.registration import corner_error
from tools.bench.vision.truth import Facade, Picture, Points, facade, graf
from tools.bench.vision.warps import KINDS, drawn_texture, warped_pairs

PEERS = ("akaze", "sift", "orb")
NAMES = {"akaze": "AKAZE", "sift": "SIFT", "orb": "ORB"}
WRONG_PX = 10.0
WORSE_PX = 1.0


@dataclass(frozen=True, eq=False)
class Case:
    """A pair, and how far a homography is from the truth, pixels; NaN where that pair has nothing to measure by."""

    a: Picture
    b: Picture
    error: Callable[[Points], float]


def methods_table(data: Path, peers: str, seed: int, count: int) -> str:
    """Median and 90 % of the errors, a refusal counted as infinite; wrong answers; processor time.

    peers: a Python with an OpenCV that has AKAZE (4); without one AKAZE is left out.
    """
    lines = ["| pairs | method | registered | error, px: median | 90 % | off by over 10 px | worse than the best "
             "single method by over 1 px | ms: median |", "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for name, cases in _sets(data, seed, count).items():
        found = {"rover register": _ours(cases)} | {
            NAMES[method]: answers
            for method in PEERS
            if (answers := _theirs(cases, peers or sys.executable, method)) is not None
        }
        errors = {method: _errors(cases, homographies) for method, (homographies, _) in found.items()}
        best = min((method for method in errors if method in NAMES.values()), key=lambda m: float(np.median(errors[m])))
        for method, (_, seconds) in found.items():
            off = errors[method]
            wrong = int((off[np.isfinite(off)] > WRONG_PX).sum())
            worse = int((off > errors[best] + WORSE_PX).sum()) if method == "rover register" else None
            beside = "–" if worse is None else f"{worse} ({best})"
            lines.append(
                f"| {name} | {method} | {np.isfinite(off).sum()} of {len(off)} | {_px(off, 50)} | {_px(off, 90)} | "
                f"{wrong} | {beside} | {np.median(seconds) * 1e3:.0f} |"
            )
    return "\n".join(lines)


def _px(errors: NDArray[np.float64], share: float) -> str:
    value = float(np.percentile(errors, share, method="lower"))
    return f"{value:.2f}" if np.isfinite(value) else "refused"


def _errors(cases: list[Case], homographies: list[Points | None]) -> NDArray[np.float64]:
    off = [
        float("inf") if homography is None else case.error(homography)
        for case, homography in zip(cases, homographies, strict=True)
    ]
    return np.array([value for value in off if not np.isnan(value)])


def _ours(cases: list[Case]) -> tuple[list[Points | None], NDArray[np.float64]]:
    homographies, seconds = [], []
    for case in cases:
        begin = time.process_time()
        homographies.append(register(case.a, case.b).homography)
        seconds.append(time.process_time() - begin)
    return homographies, np.array(seconds)


def _theirs(cases: list[Case], python: str, method: str) -> tuple[list[Points | None], NDArray[np.float64]] | None:
    with tempfile.TemporaryDirectory() as folder:
        pairs, found = Path(folder) / "pairs.npz", Path(folder) / "found.npz"
        sides: dict[str, Any] = {}
        for number, case in enumerate(cases):
            sides |= {f"a{number}": case.a, f"b{number}": case.b}
        np.savez(pairs, **sides)
        script = Path(__file__).with_name("peers.py")
        done = subprocess.run([python, str(script), str(pairs), str(found), method], capture_output=True, text=True)
        if done.returncode != 0:
            if "AKAZE" in done.stderr:
                return None
            raise RuntimeError(done.stderr)
        with np.load(found) as stored:
            answers = [h if np.isfinite(h).all() else None for h in stored["homographies"]]
            return answers, stored["seconds"]


def _sets(data: Path, seed: int, count: int) -> dict[str, list[Case]]:
    pictures, truths = graf(data)
    wall = facade(data)
    made: dict[str, list[Case]] = {
        "graf": [_known(pictures[0], b, truth) for b, truth in zip(pictures[1:], truths, strict=True)],
        "dunr, neighbours": [
            Case(wall.pictures[k], wall.pictures[k + 1], _transfer(wall, k)) for k in range(len(wall.pictures) - 1)
        ],
    }
    rng = np.random.default_rng(seed)
    mines = sorted((data / "landmines/images").glob("*.jpg"))
    real = [*pictures, *(wall.pictures[k] for k in rng.choice(len(wall.pictures), 4, replace=False)),
            *(read_picture(mines[k]) for k in rng.choice(len(mines), 4, replace=False))]  # fmt: skip
    textures = [_eight_bits(p) for p in real] + [drawn_texture(seed * 10 + k) for k in range(2)]
    for kind in KINDS:
        made[f"synthetic: {kind}"] = [_known(w.a, w.b, w.truth) for w in warped_pairs(textures, kind, count, seed)]
    return made


def _known(a: Picture, b: Picture, truth: Points) -> Case:
    return Case(a, b, lambda homography: corner_error(homography, truth, a.shape))


def _transfer(wall: Facade, first: int) -> Callable[[Points], float]:
    """Mean marker transfer from a picture of dunr to the next."""

    def error(homography: Points) -> float:
        apart = marker_transfer(wall, first, first + 1, homography)
        return float(np.mean(apart)) if apart else float("nan")

    return error


def _eight_bits(picture: Picture) -> NDArray[np.uint8]:
    low, high = np.percentile(picture, (1.0, 99.0))
    scaled = np.clip((picture.astype(np.float32) - low) * (255.0 / (high - low)), 0.0, 255.0)
    return np.asarray(scaled, np.uint8)
