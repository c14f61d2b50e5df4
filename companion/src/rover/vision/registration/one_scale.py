"""Two pictures brought to one scale before they are compared: the finer one made smaller, by what a homography says.

In a picture that shows everything twice as large other things are local contrast, and what is laid on it is blurred.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.prepared import Prepared, Pyramid, pyramid, shrunk

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Beside:
    """Pyramids of A and B at one scale, and the homographies (3, 3) from each picture to the one compared."""

    a: Pyramid
    b: Pyramid
    into_a: Points
    into_b: Points

    def inward(self, homography: Points) -> Points:
        """From the pictures' homography to that of the compared ones."""
        return normal(self.into_b @ homography @ np.linalg.inv(self.into_a))

    def outward(self, homography: Points) -> Points:
        """And back."""
        return normal(np.linalg.inv(self.into_b) @ homography @ self.into_a)


def beside(a: Prepared, b: Prepared, homography: Points, tolerated: float) -> Beside:
    """At one scale; scales that differ by less than the factor `tolerated` are left as they are."""
    zoom = zoom_of(homography, a.shape)
    if zoom > tolerated:
        small, into = shrunk(b.image, 1.0 / zoom)
        return Beside(a.pyramid, pyramid(small), np.eye(3), into)
    if zoom < 1.0 / tolerated:
        small, into = shrunk(a.image, zoom)
        return Beside(pyramid(small), b.pyramid, into, np.eye(3))
    return Beside(a.pyramid, b.pyramid, np.eye(3), np.eye(3))


def zoom_of(homography: Points, shape: tuple[int, ...]) -> float:
    """How many pixels of B a pixel of A measures, in the middle of what B may show of it: the root of its area."""
    height, width = shape
    x, y = 0.5 * width, 0.5 * height
    w = homography[2] @ (x, y, 1.0)
    return float(np.sqrt(abs(np.linalg.det(homography)) / max(abs(w) ** 3, 1e-12)))


def normal(homography: Points) -> Points:
    """Its last entry one."""
    scaled: Points = homography / homography[2, 2]
    return scaled
