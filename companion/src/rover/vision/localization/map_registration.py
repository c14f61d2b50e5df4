"""How the map of one survey lies in that of another, of the same field at another hour.

Both maps begin at the launch and are held by the same marker plates, so they lie on each other but for what each rover
was off. Three ways say more: nothing at all (launch and plates), keyframes whose features match though the hour is
another, and the mosaics themselves, which show the same stones and patches, warmer or colder than their surroundings.
The one by which the mosaics agree best is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.registration.matching import MatchSettings, hamming, mutual_matches

Raster = NDArray[np.float32]
Points = NDArray[np.float64]

# How far the maps may lie apart: metres, and degrees in steps.
REACH_M, TURNS_DEG = 0.3, (-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5)
# Features match within so many metres of where the launch puts them; a rigid motion fits within so many.
GATE_M, FITS_M = 0.35, 0.03
MATCH = MatchSettings(max_distance=64.0, ratio=0.9)
# Of matches within the gate so many agree by chance.
MIN_INLIERS, MIN_SHARE = 20, 0.05
# Structure of the ground that is compared: finer than this, metres, and no farther out than so many deviations.
STRUCTURE_M, CLIP_SIGMAS = 0.15, 3.0
# Agreement of the mosaics from which a shift by them is believed, and by how much it must be better.
MIN_AGREEMENT, BETTER = 0.15, 0.02
# Both maps begin at a launch that somebody set the rover down at by hand: 1σ of one in the other, metres.
LAUNCH_SIGMA_M = 0.03
NOWHERE = Pose2(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Registered:
    """shift: the first map's pose in the second. by: what told it. matches: that agree with it, of keyframes.

    agreement: correlation of both mosaics' structure, -1 to 1: negative where what was warm is cold. residual_m: RMS
    distance of the matches, or half a cell.
    """

    shift: Pose2
    by: str
    matches: int
    agreement: float
    residual_m: float


def register_maps(
    first: KeyframeMap,
    kelvin_first: Raster,
    second: KeyframeMap,
    kelvin_second: Raster,
    resolution: float,
    plates: bool,
) -> Registered:
    """Mosaics (rows, columns), kelvin, nan where nothing is known. plates: the second map is tied to marker plates."""
    a, b = (structure(kelvin, resolution) for kelvin in (kelvin_first, kelvin_second))
    held_by = "marker plates" if plates else "the launch"
    ways = [Registered(NOWHERE, held_by, 0, agreement(a, b, NOWHERE, resolution), LAUNCH_SIGMA_M)]
    by_keyframes = _by_keyframes(first, second)
    if by_keyframes is not None:
        shift, matches, residual = by_keyframes
        ways.append(Registered(shift, "keyframes", matches, agreement(a, b, shift, resolution), residual))
    shift = _by_mosaics(a, b, resolution)
    found = agreement(a, b, shift, resolution)
    if abs(found) >= MIN_AGREEMENT:
        ways.append(Registered(shift, "mosaics", 0, found, 0.5 * resolution))
    best = ways[0]
    for way in ways[1:]:
        if abs(way.agreement) > abs(best.agreement) + BETTER:
            best = way
    return best


def structure(kelvin: Raster, resolution: float) -> Raster:
    """What stands out locally, in robust deviations, clipped; zero where nothing is known."""
    known = np.isfinite(kelvin)
    if not known.any():
        return np.zeros(kelvin.shape, np.float32)
    middle = np.float32(np.median(kelvin[known]))
    filled = np.where(known, kelvin - middle, 0.0).astype(np.float32)
    share = cv2.GaussianBlur(known.astype(np.float32), (0, 0), STRUCTURE_M / resolution)
    smooth = cv2.GaussianBlur(filled, (0, 0), STRUCTURE_M / resolution) / np.maximum(share, 0.05)
    left = np.where(known, filled - smooth, 0.0)
    spread = max(1.4826 * float(np.median(np.abs(left[known]))), 1e-3)
    return np.clip(left / spread, -CLIP_SIGMAS, CLIP_SIGMAS).astype(np.float32)


def agreement(a: Raster, b: Raster, shift: Pose2, resolution: float) -> float:
    """Correlation of two structures (rows, columns) where both know the ground, the first moved by `shift`."""
    laid = _laid(a, shift, resolution)
    both = (laid != 0.0) & (b != 0.0)
    if both.sum() < 100:
        return 0.0
    x, y = laid[both], b[both]
    return float(x @ y / max(math.sqrt(float(x @ x) * float(y @ y)), 1e-9))


def _laid(a: Raster, shift: Pose2, resolution: float) -> Raster:
    c, s = math.cos(shift.heading), math.sin(shift.heading)
    x, y = shift.x / resolution + 0.5 * (c - s) - 0.5, shift.y / resolution + 0.5 * (s + c) - 0.5
    matrix = np.array([[c, -s, x], [s, c, y]])
    return np.asarray(cv2.warpAffine(a, matrix, a.shape[::-1], flags=cv2.INTER_LINEAR), np.float32)


def _by_mosaics(a: Raster, b: Raster, resolution: float) -> Pose2:
    """The shift of the highest correlation, of either sign, over REACH_M and TURNS_DEG about the middle."""
    reach = math.ceil(REACH_M / resolution)
    rows, columns = a.shape
    middle = 0.5 * columns * resolution, 0.5 * rows * resolution
    padded = cv2.copyMakeBorder(b, reach, reach, reach, reach, cv2.BORDER_CONSTANT, value=0.0)
    best, found = 0.0, NOWHERE
    for turn in map(math.radians, TURNS_DEG):
        c, s = math.cos(turn), math.sin(turn)
        about = Pose2(middle[0] - c * middle[0] + s * middle[1], middle[1] - s * middle[0] - c * middle[1], turn)
        score = cv2.matchTemplate(padded, _laid(a, about, resolution), cv2.TM_CCORR_NORMED)
        at = np.unravel_index(int(np.argmax(np.abs(score))), score.shape)
        if abs(float(score[at])) > best:
            best = abs(float(score[at]))
            dy, dx = ((int(place) - reach) * resolution for place in at)
            found = Pose2(about.x + dx, about.y + dy, turn)
    return found


def _by_keyframes(first: KeyframeMap, second: KeyframeMap) -> tuple[Pose2, int, float] | None:
    """The rigid motion that features of both maps agree on, how many do, and their RMS distance; None: too few."""
    if not first.frames or not second.frames:
        return None
    (there, described), frames = _features(first), _frames(second)
    starts, ends = [], []
    for points, descriptors in frames:
        centre = points.mean(axis=0)
        near = np.flatnonzero(np.hypot(*(there - centre).T) <= np.hypot(*(points - centre).T).max() + GATE_M)
        if not len(near):
            continue
        allowed = np.hypot(points[:, None, 0] - there[near, 0], points[:, None, 1] - there[near, 1]) <= GATE_M
        rows, columns = mutual_matches(hamming(descriptors, described[near]), allowed, MATCH)
        starts.append(there[near[columns]])
        ends.append(points[rows])
    if not starts:
        return None
    start, end = np.concatenate(starts), np.concatenate(ends)
    if len(start) < MIN_INLIERS:
        return None
    cv2.setRNGSeed(1)
    rigid, agree = cv2.estimateAffinePartial2D(start, end, method=cv2.RANSAC, ransacReprojThreshold=FITS_M)
    if rigid is None:
        return None  # type: ignore[unreachable]  # the stub does not know that there may be none
    inlier = agree.ravel() > 0
    if inlier.sum() < max(MIN_INLIERS, MIN_SHARE * len(start)):
        return None
    a, b = start[inlier], end[inlier]
    # The rotation that suits best (Kabsch); what scale there is in it is noise.
    mean_a, mean_b = a.mean(axis=0), b.mean(axis=0)
    (xx, xy), (yx, yy) = ((a - mean_a).T @ (b - mean_b)).tolist()
    turn = math.atan2(xy - yx, xx + yy)
    c, s = math.cos(turn), math.sin(turn)
    x, y = mean_b - np.array([[c, -s], [s, c]]) @ mean_a
    shift = Pose2(float(x), float(y), turn)
    if math.hypot(*(mean_b - mean_a)) > GATE_M:
        return None
    left = shift.transform(a) - b
    return shift, int(inlier.sum()), float(np.sqrt(np.mean(np.sum(left**2, axis=1))))


def _frames(known: KeyframeMap) -> list[tuple[Points, NDArray[np.uint8]]]:
    """Of every keyframe its features in map (N, 2), and their descriptors."""
    found = []
    for submap, at in zip(known.submaps, known.submap_poses, strict=True):
        for frame, (x, y, heading) in zip(submap.frames, submap.poses.tolist(), strict=True):
            found.append((at.compose(Pose2(x, y, heading)).transform(frame.ground), frame.descriptors))
    return found


def _features(known: KeyframeMap) -> tuple[Points, NDArray[np.uint8]]:
    frames = _frames(known)
    return np.concatenate([points for points, _ in frames]), np.concatenate([found for _, found in frames])
