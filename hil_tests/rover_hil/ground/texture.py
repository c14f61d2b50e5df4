"""The natural unevenness of bare ground: temperature noise on many scales, patches, millimetres of roughness."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.raster import Grid

# (correlation length in metres, rms in kelvin): together about 0.33 K.
SOIL_SCALES = ((0.40, 0.14), (0.15, 0.14), (0.06, 0.14), (0.025, 0.14), (0.009, 0.16))
ROUGHNESS_SCALES = ((0.10, 0.0015), (0.02, 0.0008))


def correlated_noise(grid: Grid, length: float, rms: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Gaussian noise (rows, columns) of the given correlation length (m) and rms.

    Coarse scales are drawn on a coarse lattice and enlarged, so that the cost does not grow with `length`.
    """
    step = max(1, int(length / (2.0 * grid.resolution)))
    rows, columns = -(-grid.rows // step) + 2, -(-grid.columns // step) + 2
    lattice = rng.standard_normal((rows, columns), dtype=np.float32)
    sigma = 0.5 * length / (grid.resolution * step)
    smooth = cv2.GaussianBlur(lattice, (0, 0), max(sigma, 0.3), borderType=cv2.BORDER_REFLECT)
    if step > 1:
        smooth = cv2.resize(smooth, (columns * step, rows * step), interpolation=cv2.INTER_CUBIC)
    noise = np.asarray(smooth, np.float32)[: grid.rows, : grid.columns]
    return np.asarray(noise * np.float32(rms / max(float(noise.std()), 1e-9)), np.float32)


def soil_texture(grid: Grid, rng: np.random.Generator) -> NDArray[np.float32]:
    """Temperature deviations of bare soil, K: the scales of `SOIL_SCALES` added up."""
    return sum_of_scales(grid, SOIL_SCALES, rng)


def roughness(grid: Grid, rng: np.random.Generator) -> NDArray[np.float32]:
    """Height of bare soil, m: millimetres."""
    return sum_of_scales(grid, ROUGHNESS_SCALES, rng)


def sum_of_scales(
    grid: Grid, scales: tuple[tuple[float, float], ...], rng: np.random.Generator
) -> NDArray[np.float32]:
    """The sum of `correlated_noise` over (length, rms) pairs."""
    total = np.zeros(grid.shape, dtype=np.float32)
    for length, rms in scales:
        total += correlated_noise(grid, length, rms, rng)
    return total


def lay_patches(
    raster: NDArray[np.float32], grid: Grid, rng: np.random.Generator, per_square_metre: float = 0.35
) -> None:
    """Add damp (cooler) and bare (warmer) patches in place: smooth, irregular, 0.3 to 0.8 K, 15 to 40 cm.

    They are no obstacles: a detector has to reject them, by their size and their crooked outline.
    """
    width, height = grid.columns * grid.resolution, grid.rows * grid.resolution
    for _ in range(round(per_square_metre * width * height)):
        centre = (grid.origin_x + rng.uniform(0, width), grid.origin_y + rng.uniform(0, height))
        long_half = rng.uniform(0.15, 0.40)
        short_half = long_half * rng.uniform(0.35, 0.75)
        turn = rng.uniform(0, np.pi)
        kelvin = rng.uniform(0.3, 0.8) * (1 if rng.random() < 0.5 else -1)
        crook = rng.uniform(-0.35, 0.35, size=2)
        phase = rng.uniform(0, 2 * np.pi, size=2)
        window = grid.window(centre, 2.0 * long_half)
        dx, dy = grid.offsets(window, centre)
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        angle = np.arctan2(across / short_half, along / long_half)
        outline = 1 + crook[0] * np.cos(2 * angle + phase[0]) + crook[1] * np.cos(3 * angle + phase[1])
        distance = np.hypot(along / long_half, across / short_half) / outline
        raster[window] += (kelvin / (1 + np.clip(distance, 0, 4) ** 6)).astype(np.float32)
