"""Pairs of landmines that were looked at: which overlap by over half, and where the one lies in the other.

`landmines_pairs.csv` holds every fifth pair of consecutive pictures of a session and pairs from different places. Each
was judged by eye from both pictures side by side and, where they were registered, from a chessboard of both and a
composite in two colours. overlap: "over" when more than half of either picture shows what the other shows, else "less"
(down to nothing that can be recognised), "none" for different places. corners: where A's corners lie in B (x y,
clockwise from the upper left one), of a registration that was found right; empty where there was none to look at.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import read_picture, write_picture
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.preprocess import local_contrast
from rover.vision.registration.register import Registration, RegistrationSettings, register

from tools.bench.vision.plain import plain_features, plain_homography
from tools.bench.vision.truth import Picture, Points

LIST = Path(__file__).with_name("landmines_pairs.csv")
# Mean distance of the corners from where they were found right.
MIN_WRONG_PX = 10.0


@dataclass(frozen=True, eq=False)
class Judged:
    """A pair by the names of its pictures; overlap: over, less or none; corners: (4, 2) pixels of B, or None."""

    a: str
    b: str
    overlap: str
    corners: Points | None

    def pictures(self, data: Path) -> tuple[Picture, Picture]:
        """Both pictures (H, W)."""
        folder = data / "landmines/images"
        return read_picture(folder / f"{self.a}.jpg"), read_picture(folder / f"{self.b}.jpg")

    def wrong(self, homography: Points | None, shape: tuple[int, ...]) -> bool:
        """True for a homography that is not the one found right, or any between different places."""
        if homography is None:
            return False
        if self.corners is None:
            return self.overlap == "none"
        height, width = shape[:2]
        corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
        apart = np.linalg.norm(apply_homography(homography, corners) - self.corners, axis=1)
        return float(apart.mean()) > MIN_WRONG_PX


def judged_pairs() -> list[Judged]:
    """The list, in its order."""
    with LIST.open(newline="") as file:
        return [Judged(row["a"], row["b"], row["overlap"], _corners(row["corners"])) for row in csv.DictReader(file)]


def _corners(text: str) -> Points | None:
    return np.array(text.split(), float).reshape(4, 2) if text else None


def pairs_table(data: Path, sheets: Path | None = None) -> str:
    """Registered of those that overlap by over half, and how many are wrong, beside plain OpenCV.

    sheets: a folder for a picture of each registered pair, to be looked at.
    """
    listed = judged_pairs()
    found: list[Registration] = []
    plain: list[Points | None] = []
    for pair in listed:
        a, b = pair.pictures(data)
        found.append(register(a, b, RegistrationSettings()))
        plain.append(plain_homography(plain_features(a), plain_features(b)))
        homography = found[-1].homography
        if sheets is not None and homography is not None:
            sheets.mkdir(parents=True, exist_ok=True)
            write_picture(sheets / f"{pair.a}-{pair.b}.png", chessboard(a, b, homography))
    lines = ["| landmines, pairs judged by eye | overlap over half | registered | overlap less or none | registered | "
             "wrong of all registered |", "|---|---|---|---|---|---|"]  # fmt: skip
    shape = listed[0].pictures(data)[0].shape
    for name, homographies in (("rover register", [r.homography for r in found]), ("plain ORB + RANSAC", plain)):
        lines.append(f"| {name} | " + " | ".join(map(str, _counted(listed, homographies, shape))) + " |")
    refused = [f"{p.a} ({r.reason})" for p, r in zip(listed, found, strict=True)
               if p.overlap == "over" and r.homography is None]  # fmt: skip
    lines += ["", "Refused though over half, each with its successor: " + (", ".join(refused) or "none") + "."]
    return "\n".join(lines)


def _counted(listed: list[Judged], homographies: Iterable[Points | None], shape: tuple[int, ...]) -> list[int]:
    done = list(zip(listed, homographies, strict=True))
    over = [h for pair, h in done if pair.overlap == "over"]
    rest = [h for pair, h in done if pair.overlap != "over"]
    wrong = sum(pair.wrong(h, shape) for pair, h in done)
    return [len(over), sum(h is not None for h in over), len(rest), sum(h is not None for h in rest), wrong]


def chessboard(a: Picture, b: Picture, homography: Points, tiles: int = 8) -> NDArray[np.uint8]:
    """B and, in every second tile, A laid on it: edges that run on across tiles show that the homography is right."""
    height, width = b.shape[:2]
    laid = cv2.warpPerspective(local_contrast(a), homography, (width, height))
    v, u = np.mgrid[0:height, 0:width]
    mixed = local_contrast(b)
    from_a = ((u * tiles // width + v * tiles // height) % 2 == 0) & (laid > 0)
    mixed[from_a] = laid[from_a]
    return mixed
