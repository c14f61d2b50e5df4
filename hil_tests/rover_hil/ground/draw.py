"""A false-colour picture of a ground with what lies in it, for a person to look at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rover_hil.ground.field import Ground

PIXELS_PER_METRE = 150
WHITE, BLACK = (255, 255, 255), (0, 0, 0)


def picture(ground: Ground, marks: bool = True) -> NDArray[np.uint8]:
    """BGR picture (h, w, 3), y up, temperatures between percentiles 2 and 99.5, with marks and a legend."""
    low, high = np.percentile(ground.temperature, [2.0, 99.5])
    scaled = np.clip((ground.temperature - low) / max(high - low, 1e-6) * 255, 0, 255).astype(np.uint8)
    colour = cv2.applyColorMap(np.flipud(scaled), cv2.COLORMAP_INFERNO)
    factor = PIXELS_PER_METRE * ground.resolution
    colour = cv2.resize(colour, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    if not marks:
        return colour
    rows = colour.shape[0]

    def pixel(x: float, y: float) -> tuple[int, int]:
        column = round((x - ground.origin_x) * PIXELS_PER_METRE)
        return column, rows - round((y - ground.origin_y) * PIXELS_PER_METRE)

    def label(text: str, at: tuple[int, int]) -> None:
        for tone, width in ((BLACK, 3), (WHITE, 1)):
            cv2.putText(colour, text, at, cv2.FONT_HERSHEY_PLAIN, 1.0, tone, width, cv2.LINE_AA)

    cv2.rectangle(colour, pixel(0, 0), pixel(*ground.area), WHITE, 1)
    for (x, y, r, _), kind in zip(ground.obstacles.tolist(), ground.obstacle_kinds, strict=True):
        tone = (0, 220, 0) if kind == "grass" else (255, 180, 60)
        cv2.circle(colour, pixel(x, y), round(r * PIXELS_PER_METRE), tone, 1, cv2.LINE_AA)
    for mine in ground.mines:
        column, row = pixel(mine.x, mine.y)
        cv2.circle(colour, (column, row), round(0.12 * PIXELS_PER_METRE), (255, 255, 0), 1, cv2.LINE_AA)
        where = "surface" if mine.kind == "surface" else f"{mine.depth * 100:g} cm"
        label(f"{mine.id}: {where} {mine.contrast_k:+.1f} K", (column + 20, row - 6))
    hour = f"{int(ground.hour):02d}:{round(ground.hour % 1 * 60):02d}"
    source = ground.texture.get("kind", "")
    label(
        f"{ground.soil} {hour}  {low - 273.15:.1f}..{high - 273.15:.1f} C  seed {ground.seed}  {source}",
        (8, 18),
    )
    return colour
