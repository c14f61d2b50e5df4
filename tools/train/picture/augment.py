"""Other pictures out of the ones there are: turned, seen from nearer or farther, other contrast, sharpened or blurred,
and with smooth discs laid on the ground, which is how a casing on the surface shows: the set has only two of those.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.train.picture.records import Box, Record

Grey = NDArray[np.float32]
# Radii of drawn casings, pixels: as the set's casings measure from 1 to 4 m, and somewhat beyond.
MIN_DISC_PX, MAX_DISC_PX = 16.0, 100.0
# How much larger or smaller things are when the camera is at another height.
MIN_ZOOM, MAX_ZOOM = 0.7, 1.5


def turned(record: Record, rng: np.random.Generator) -> tuple[Grey, tuple[Box, ...]]:
    """A random one of the eight turns and mirror images, with its boxes."""
    picture, boxes = record.grey.astype(np.float32), record.boxes
    rows, columns = picture.shape
    if rng.random() < 0.5:
        picture, boxes = picture[:, ::-1], tuple(replace(b, x=columns - b.x) for b in boxes)
    if rng.random() < 0.5:
        picture, boxes = picture[::-1], tuple(replace(b, y=rows - b.y) for b in boxes)
    if rng.random() < 0.25:
        picture = picture.T
        boxes = tuple(replace(b, x=b.y, y=b.x, width=b.height, height=b.width) for b in boxes)
    return np.ascontiguousarray(picture), boxes


def from_another_height(
    picture: Grey, boxes: tuple[Box, ...], rng: np.random.Generator
) -> tuple[Grey, tuple[Box, ...]]:
    """From farther: the picture shrunk. From nearer: a part of it that holds all boxes whole, enlarged; where none is
    found by chance, the picture as it is."""
    zoom = float(np.exp(rng.uniform(math.log(MIN_ZOOM), math.log(MAX_ZOOM))))
    rows, columns = picture.shape
    if zoom < 1.0:
        size = (round(columns * zoom), round(rows * zoom))
        shrunk = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.float32)
        return shrunk, tuple(_moved(b, 0.0, 0.0, size[0] / columns, size[1] / rows) for b in boxes)
    width, height = round(columns / zoom), round(rows / zoom)
    for _ in range(20):
        left, top = int(rng.integers(0, columns - width + 1)), int(rng.integers(0, rows - height + 1))
        in_width = all(left <= b.x - b.width / 2 and b.x + b.width / 2 <= left + width for b in boxes)
        if in_width and all(top <= b.y - b.height / 2 and b.y + b.height / 2 <= top + height for b in boxes):
            part = cv2.resize(picture[top : top + height, left : left + width], (columns, rows))
            enlarged = tuple(_moved(b, left, top, columns / width, rows / height) for b in boxes)
            return np.asarray(part, np.float32), enlarged
    return picture, boxes


def _moved(box: Box, left: float, top: float, across: float, down: float) -> Box:
    x, y = (box.x - left) * across, (box.y - top) * down
    return replace(box, x=x, y=y, width=box.width * across, height=box.height * down)


def with_disc(picture: Grey, boxes: tuple[Box, ...], rng: np.random.Generator) -> tuple[Grey, tuple[Box, ...]]:
    """A casing: an even disc warmer or colder than the ground, often with a plug in its middle and grass across it."""
    rows, columns = picture.shape
    radius = float(np.exp(rng.uniform(math.log(MIN_DISC_PX), math.log(MAX_DISC_PX))))
    for _ in range(20):
        x, y = float(rng.uniform(radius, columns - radius)), float(rng.uniform(radius, rows - radius))
        if all(max(abs(x - b.x) - b.width / 2, abs(y - b.y) - b.height / 2) > 1.6 * radius for b in boxes):
            break
    else:
        return picture, boxes
    stretch, tilt = float(rng.uniform(0.8, 1.25)), float(rng.uniform(0, math.pi))
    v, u = np.mgrid[0:rows, 0:columns].astype(np.float32)
    du, dv = u - np.float32(x), v - np.float32(y)
    across = (du * math.cos(tilt) + dv * math.sin(tilt)) * stretch
    along = -du * math.sin(tilt) + dv * math.cos(tilt)
    distance = np.sqrt(across * across + along * along)
    near = distance < 1.8 * radius
    middle, spread = float(np.median(picture[near])), float(picture[near].std()) + 3.0
    contrast = spread * float(rng.uniform(0.5, 5.0)) * (1.0 if rng.random() < 0.65 else -1.0)
    edge = max(0.6, 0.03 * radius * float(rng.uniform(0.5, 2.5)))
    disc = middle + contrast + contrast * float(rng.normal(0, 0.15)) * along / radius
    if rng.random() < 0.7:
        plug = radius * float(rng.uniform(0.15, 0.35))
        off = radius * rng.uniform(-0.15, 0.15, 2)
        at = np.hypot(du - off[0], dv - off[1])
        disc -= contrast * float(rng.uniform(0.3, 1.3)) * _inside(at, plug, edge)
    if rng.random() < 0.4:
        disc += contrast * float(rng.uniform(-0.6, 0.3)) * _inside(np.abs(distance - 0.9 * radius), 0.1 * radius, edge)
    share = _inside(distance, radius, edge)
    if rng.random() < 0.5:
        share *= 1.0 - _blades(picture.shape, x, y, radius, rng)
    disc += float(rng.uniform(0.0, 0.15)) * (picture - middle)
    kind = Box(x, y, 2.1 * radius, 2.1 * radius, "surface")
    return (picture + share * (disc - picture)).astype(np.float32), (*boxes, kind)


def _inside(distance: Grey, radius: float, edge: float) -> Grey:
    share: Grey = (1.0 / (1.0 + np.exp(np.clip((distance - radius) / edge, -30.0, 30.0)))).astype(np.float32)
    return share


def _blades(shape: tuple[int, int], x: float, y: float, radius: float, rng: np.random.Generator) -> Grey:
    """Mask of blades of grass across the disc."""
    mask = np.zeros(shape, np.float32)
    for _ in range(int(rng.integers(1, 9))):
        ends = rng.uniform(-1.3, 1.3, 4) * radius + (x, y, x, y)
        a, b, c, d = (round(e) for e in ends.tolist())
        cv2.line(mask, (a, b), (c, d), 1.0, max(1, round(radius * float(rng.uniform(0.02, 0.08)))), cv2.LINE_AA)
    return _blurred(mask, 0.7)


def _blurred(picture: Grey, sigma: float) -> Grey:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma), picture.dtype)


def restyled(picture: Grey, rng: np.random.Generator) -> Grey:
    """Another camera's idea of the same picture: gamma, gain, blur, sharpening, local equalisation, noise."""
    picture = 255.0 * (np.clip(picture, 0.0, 255.0) / 255.0) ** np.float32(rng.uniform(0.7, 1.4))
    picture = picture * np.float32(rng.uniform(0.5, 1.1)) + np.float32(rng.uniform(0, 20))
    if rng.random() < 0.3:
        picture = _blurred(picture, float(rng.uniform(0.5, 1.3)))
    if rng.random() < 0.4:
        # Cameras that bring out detail also flatten what is wider than it.
        low = _blurred(picture, float(rng.uniform(2, 12)))
        flat = low.mean() + (low - low.mean()) * np.float32(rng.uniform(0.3, 1.0))
        picture = flat + (picture - low) * np.float32(rng.uniform(1.2, 3.0))
    if rng.random() < 0.3:
        equalise = cv2.createCLAHE(float(rng.uniform(1.5, 4.0)), (8, 8))
        picture = equalise.apply(np.clip(picture, 0, 255).astype(np.uint8)).astype(np.float32)
    if rng.random() < 0.1:
        picture = 255.0 - picture
    noisy = picture + rng.normal(0, rng.uniform(0, 4), picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8).astype(np.float32)
