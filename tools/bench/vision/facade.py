"""The façade of dunr: pairs, the mosaic, and the camera's way, against what was surveyed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from rover.vision.camera.pose import CameraPose
from rover.vision.mosaic.picture_graph import GraphSettings, Placement, place_pictures
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.register import RegistrationSettings, prepare, register_prepared
from rover.vision.tracking.sequence import SequenceSettings, track_sequence

from tools.bench.vision.plain import plain_features, plain_homography
from tools.bench.vision.seams import seam_table
from tools.bench.vision.truth import WIRIS, Facade, Points, facade


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
    placement = place_pictures(wall.pictures, GraphSettings())
    off = _mosaic_errors(wall, placement)
    lines += [
        "",
        f"Equation 6 over these pairs: {before:.1f} px before, {after:.2f} px after (median); the paper: 65.7, 63.2.",
        "",
        f"`rover track`: {tracked} of {len(wall.pictures)} frames; relative rotation off by {np.median(turned):.2f}°, "
        f"direction of translation by {np.median(aside):.2f}° (medians over consecutive frames).",
    ]
    lines += [
        "",
        "| the mosaic of all pictures | placed | equation 6 over its ties, px | markers seen | their distance from one "
        "plane's homography, px: median | RMS | most |",
        "|---|---|---|---|---|---|---|",
        f"| rover stitch | {len(placement.homographies)} of {len(wall.pictures)} | {placement.rmse_px:.2f} | "
        f"{len(off)} | {np.median(off):.2f} | {float(np.sqrt(np.mean(np.square(off)))):.2f} | {max(off):.2f} |",
        "",
        seam_table(wall.pictures, placement),
    ]
    return "\n".join(lines)


def _transfer(wall: Facade, homographies: Sequence[Points | None]) -> list[float]:
    apart: list[float] = []
    for k, homography in enumerate(homographies):
        if homography is not None:
            apart += marker_transfer(wall, k, k + 1, homography)
    return apart


def marker_transfer(wall: Facade, a: int, b: int, homography: Points) -> list[float]:
    """How far the markers seen in both pictures lie in b from where the homography puts those of a, pixels."""
    both = sorted(set(wall.markers[a]) & set(wall.markers[b]))
    if not both:
        return []
    here, there = (np.array([wall.markers[k][marker] for marker in both]) for k in (a, b))
    apart = np.linalg.norm(apply_homography(homography, here) - there, axis=1)
    return [float(distance) for distance in apart]


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


def _mosaic_errors(wall: Facade, placement: Placement) -> list[float]:
    """Distances between the markers in the mosaic and where one homography of the wall's plane puts them, pixels."""
    surveyed, shown = [], []
    for number, homography in sorted(placement.homographies.items()):
        for marker, pixel in sorted(wall.markers[number].items()):
            surveyed.append(wall.survey[marker])
            shown.append(apply_homography(homography, np.array([pixel]))[0])
    found, _ = cv2.findHomography(np.array(surveyed), np.array(shown), 0)
    onto = np.asarray(found, np.float64)
    apart = np.linalg.norm(apply_homography(onto, np.array(surveyed)) - np.array(shown), axis=1)
    return [float(distance) for distance in apart]
