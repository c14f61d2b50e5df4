"""The peer: OpenCV's ORB, brute-force matching with cross-check, RANSAC homography; its defaults, and no refusal."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Picture = NDArray[np.uint8] | NDArray[np.uint16]
PlainFeatures = tuple[Points, NDArray[np.uint8]]
FEATURES = 2000
MAX_RANSAC_PX = 3.0
MIN_MATCHES = 8


def plain_features(picture: Picture) -> PlainFeatures:
    """Pixels (N, 2) and descriptors of a picture (H, W) of 8 or 16 bits."""
    keys, seen = cv2.ORB.create(nfeatures=FEATURES).detectAndCompute(eight_bits(picture), None)
    points = np.array([key.pt for key in keys], np.float64).reshape(-1, 2)
    return points, np.empty((0, 32), np.uint8) if seen is None else np.asarray(seen, np.uint8)


def plain_homography(a: PlainFeatures, b: PlainFeatures) -> Points | None:
    """A to B (3, 3), None where RANSAC finds nothing."""
    if min(len(a[0]), len(b[0])) < MIN_MATCHES:
        return None
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(a[1], b[1])
    if len(matches) < MIN_MATCHES:
        return None
    points_a, points_b = a[0][[m.queryIdx for m in matches]], b[0][[m.trainIdx for m in matches]]
    cv2.setRNGSeed(1)
    homography, _ = cv2.findHomography(points_a, points_b, cv2.RANSAC, MAX_RANSAC_PX)
    return None if homography is None else np.asarray(homography, np.float64)


def eight_bits(picture: Picture) -> NDArray[np.uint8]:
    """Minimum to maximum as 0 to 255."""
    grey = np.empty(picture.shape, np.uint8)
    return np.asarray(cv2.normalize(picture, grey, 0, 255, cv2.NORM_MINMAX, cv2.CV_8U), np.uint8)
