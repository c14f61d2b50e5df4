"""Synthetic pairs: one real or drawn texture seen twice, under a zoom, a turn, a tilt, noise and blur, with the truth.

Both pictures of a pair are resampled from the texture, so that neither is sharper than a camera's; what is enlarged is
never sharper than the texture, what is reduced is smoothed first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Grey = NDArray[np.uint8]

SIZE = (400, 320)
KINDS = ("zoom", "warp", "noise", "turn")


@dataclass(frozen=True, eq=False)
class Warped:
    """name: what was done. a, b: (H, W) uint8. truth: (3, 3) from a to b."""

    name: str
    a: Grey
    b: Grey
    truth: Points


def warped_pairs(textures: list[Grey], kind: str, count: int, seed: int) -> Iterator[Warped]:
    """`count` pairs of one kind; the textures take turns. zoom: 1.5 to 4; warp: tilt; noise: noise and blur; turn."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    for number in range(count):
        texture = textures[number % len(textures)]
        zoom = {"zoom": 1.5 * (4.0 / 1.5) ** rng.random()}.get(kind, rng.uniform(0.8, 1.25))
        angle = rng.uniform(-180.0, 180.0) if kind in ("turn", "zoom") and number % 2 else rng.uniform(-12.0, 12.0)
        tilt = rng.uniform(0.1, 0.35) if kind == "warp" else rng.uniform(0.0, 0.06)
        noise, blur = (rng.uniform(6.0, 20.0), rng.uniform(0.6, 1.6)) if kind == "noise" else (2.0, 0.3)
        whole = _view(texture, 1.0, 0.0, 0.0, 0.0, (0.0, 0.0))
        shift = rng.uniform(-0.12, 0.12, 2)
        near = _view(texture, zoom, angle, tilt, rng.uniform(0.0, 360.0), (float(shift[0]), float(shift[1])))
        a, b = (_seen(texture, view, noise, blur, rng) for view in (whole, near))
        truth = near @ np.linalg.inv(whole)
        if number % 4 >= 2:
            a, b, truth = b, a, np.asarray(np.linalg.inv(truth))
        yield Warped(f"{kind} {number}: ×{zoom:.1f}, {angle:.0f}°", a, b, truth / truth[2, 2])


def _view(texture: Grey, zoom: float, angle: float, tilt: float, towards: float, shift: tuple[float, float]) -> Points:
    """The homography (3, 3) from the texture to a picture of SIZE; zoom 1 shows all that fits."""
    height, width = texture.shape
    scale = zoom * max(SIZE[0] / width, SIZE[1] / height)
    to_middle = np.array(
        [[1.0, 0.0, -width * (0.5 + shift[0] / zoom)], [0.0, 1.0, -height * (0.5 + shift[1] / zoom)], [0.0, 0.0, 1.0]]
    )
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[scale * c, -scale * s, 0.0], [scale * s, scale * c, 0.0], [0.0, 0.0, 1.0]])
    along = np.radians(towards)
    slope = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [tilt * np.cos(along) / SIZE[0] * 2, tilt * np.sin(along) / SIZE[0] * 2, 1.0],
        ]
    )
    back = np.array([[1.0, 0.0, SIZE[0] / 2], [0.0, 1.0, SIZE[1] / 2], [0.0, 0.0, 1.0]])
    return np.asarray(back @ slope @ turn @ to_middle)


def _seen(texture: Grey, view: Points, noise: float, blur: float, rng: np.random.Generator) -> Grey:
    """The texture through a view, smoothed before it is reduced, with gain, offset, blur and noise."""
    middle = np.linalg.inv(view) @ np.array([SIZE[0] / 2, SIZE[1] / 2, 1.0])
    x, y = middle[:2] / middle[2]
    at = np.array([[x, y, 1.0], [x + 1.0, y, 1.0], [x, y + 1.0, 1.0]]) @ view.T
    corner, right, below = at[:, :2] / at[:, 2:]
    scale = np.sqrt(abs(np.linalg.det(np.stack((right - corner, below - corner)))))
    source: NDArray[Any] = texture.astype(np.float32)
    if scale < 1.0:
        source = cv2.GaussianBlur(source, (0, 0), 0.5 * np.sqrt(1.0 / scale**2 - 1.0) + 1e-3)
    picture = cv2.warpPerspective(source, view, SIZE, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101)
    picture = cv2.GaussianBlur(picture, (0, 0), blur)
    picture = (picture - 128.0) * rng.uniform(0.7, 1.1) + 128.0 + rng.uniform(-20.0, 20.0)
    return np.clip(np.rint(picture + noise * rng.standard_normal(picture.shape)), 0, 255).astype(np.uint8)


def drawn_texture(seed: int, size: tuple[int, int] = (960, 768)) -> Grey:
    """Ground of no camera (H, W): noise of many scales with discs and strips of other temperature on it."""
    rng = np.random.default_rng(seed)
    width, height = size
    picture = np.zeros((height, width), np.float32)
    for sigma in (1.0, 2.0, 4.0, 8.0, 16.0, 32.0):
        layer = cv2.GaussianBlur(rng.standard_normal((height, width)).astype(np.float32), (0, 0), sigma)
        picture += layer / layer.std() * sigma**0.6
    for _ in range(60):
        at = int(rng.integers(width)), int(rng.integers(height))
        cv2.circle(picture, at, int(rng.integers(4, 30)), float(rng.normal(0.0, 12.0)), -1, cv2.LINE_AA)
    low, high = np.percentile(picture, (1.0, 99.0))
    return np.asarray(np.clip((picture - low) / (high - low) * 255.0, 0.0, 255.0), np.uint8)
