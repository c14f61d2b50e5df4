"""The peers by themselves: OpenCV's AKAZE, SIFT and ORB, ratio test, USAC_MAGSAC; a refusal below 8 inliers.

    PYTHON peers.py PAIRS.npz FOUND.npz METHOD

imports nothing but OpenCV and NumPy, so that it runs in another environment: OpenCV 5 has no AKAZE any more.
PAIRS.npz: a0, b0, a1, b1, … (H, W) of 8 or 16 bits. FOUND.npz: homographies (N, 3, 3), NaN where refused, and
seconds (N,) of processor time of each pair, everything from pixels to homography.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import cv2
import numpy as np

RATIO = {"akaze": 0.8, "sift": 0.75, "orb": 0.8}
MAX_FEATURES = 2000
INLIER_PX = 3.0
MIN_INLIERS = 8


def main(pairs_file: str, found_file: str, method: str) -> None:
    """Registers every pair by one method."""
    cv2.setNumThreads(1)
    stored = np.load(pairs_file)
    count = len(stored.files) // 2
    homographies, seconds = np.full((count, 3, 3), np.nan), np.zeros(count)
    for number in range(count):
        begin = time.process_time()
        found = homography(stored[f"a{number}"], stored[f"b{number}"], method)
        seconds[number] = time.process_time() - begin
        if found is not None:
            homographies[number] = found
    np.savez(found_file, homographies=homographies, seconds=seconds)


def homography(a: Any, b: Any, method: str) -> Any:
    """A to B (3, 3), or None."""
    detector = detector_of(method)
    (keys_a, seen_a), (keys_b, seen_b) = (detector.detectAndCompute(eight_bits(p), None) for p in (a, b))
    if seen_a is None or seen_b is None or min(len(keys_a), len(keys_b)) < MIN_INLIERS:
        return None
    matcher = cv2.BFMatcher(cv2.NORM_L2 if method == "sift" else cv2.NORM_HAMMING)
    matches = [m for m, n in matcher.knnMatch(seen_a, seen_b, k=2) if m.distance < RATIO[method] * n.distance]
    if len(matches) < MIN_INLIERS:
        return None
    cv2.setRNGSeed(1)
    found, inliers = cv2.findHomography(
        np.array([keys_a[m.queryIdx].pt for m in matches]),
        np.array([keys_b[m.trainIdx].pt for m in matches]),
        cv2.USAC_MAGSAC,
        INLIER_PX,
        maxIters=5000,
        confidence=0.999,
    )
    return None if found is None or int(inliers.sum()) < MIN_INLIERS else found


def detector_of(method: str) -> Any:
    """OpenCV's detector with its defaults; ORB with as many features as `rover register` looks for."""
    if method == "sift":
        return cv2.SIFT.create()
    if method == "orb":
        return cv2.ORB.create(MAX_FEATURES)
    return cv2.AKAZE.create()  # type: ignore[attr-defined]  # not in OpenCV 5


def eight_bits(picture: Any) -> Any:
    """The 1st to the 99th percentile of (H, W) as 0 to 255."""
    low, high = np.percentile(picture, (1.0, 99.0))
    return np.clip((picture.astype(np.float32) - low) * (255.0 / max(high - low, 1e-6)), 0, 255).astype(np.uint8)


if __name__ == "__main__":
    main(*sys.argv[1:])
