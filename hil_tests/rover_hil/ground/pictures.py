"""Real long-wave-infrared pictures of a mined field, brought to metres and to an assumed scale in kelvin.

The pictures are 8-bit and contrast-stretched, not radiometric: what comes out is real texture at an assumed
scale. Everything slower than `TREND_M` is removed and the rest scaled so that the soil of every picture has a
standard deviation of `TEXTURE_KELVIN` outside its labelled boxes.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

TEXTURE_KELVIN = 0.6
CLIP_KELVIN = 6.0
# Gaussian sigma of the trend that is taken out.
TREND_M = 0.5
# Heights written below this are unreliable.
MIN_HEIGHT_M = 3.0
# Half angles of the lens, across and down: an estimate, consistent with the boxes from 3 m up.
HALF_ACROSS = math.radians(16.0)
HALF_DOWN = math.radians(13.0)
UNKNOWN_DEPTH = -1.0


@dataclass(frozen=True)
class Entry:
    """One picture of the index; `depth` in metres, 0 on the surface, `UNKNOWN_DEPTH` where it is not told.

    `boxes` (cx, cy, w, h) in metres from the picture's upper left corner, x right, y down.
    """

    name: str
    zone: str
    depth: float
    camera_height: float
    width: float
    height: float
    boxes: tuple[tuple[float, float, float, float], ...]


def read_index(data_dir: str | Path) -> tuple[Entry, ...]:
    """Every picture taken from at least `MIN_HEIGHT_M`, in the order of the index.

    Raises:
        BadInput: the folder, its index or a label file is missing or malformed.
    """
    folder = Path(data_dir) / "landmines"
    index = folder / "index.csv"
    if not index.is_file():
        raise BadInput(f"{index}: not found; --data must name the folder that holds landmines/index.csv")
    entries = []
    with index.open(newline="") as file:
        for line, row in enumerate(csv.DictReader(file), start=2):
            try:
                entry = _entry(folder, row)
            except (KeyError, TypeError, ValueError, OSError) as error:
                raise BadInput(
                    f"{index} line {line}: {error}: expected the columns and labels of the set"
                ) from error
            if entry is not None:
                entries.append(entry)
    if not entries:
        raise BadInput(f"{index}: holds no picture taken from {MIN_HEIGHT_M:g} m or higher")
    return tuple(entries)


def _entry(folder: Path, row: dict[str, str]) -> Entry | None:
    camera_height = float(row["height_m"])
    if camera_height < MIN_HEIGHT_M:
        return None
    width = 2 * camera_height * math.tan(HALF_ACROSS)
    height = 2 * camera_height * math.tan(HALF_DOWN)
    boxes = []
    for text in (folder / "labels" / f"{row['name']}.txt").read_text().splitlines():
        if text.strip():
            _, cx, cy, w, h = (float(part) for part in text.split())
            boxes.append((cx * width, cy * height, w * width, h * height))
    depth = float(row["depth_cm"]) / 100.0 if row["depth_cm"].strip() else UNKNOWN_DEPTH
    return Entry(row["name"], row["zone"], depth, camera_height, width, height, tuple(boxes))


def distinct(entries: Sequence[Entry]) -> list[Entry]:
    """One entry for each picture that was taken: the set holds some several times, as `zone1_B_0014_2`."""
    first: dict[str, Entry] = {}
    for entry in entries:
        first.setdefault("_".join(entry.name.split("_")[:3]), entry)
    return list(first.values())


def deviations(data_dir: str | Path, entry: Entry, resolution: float) -> NDArray[np.float32]:
    """The picture as kelvin above its own trend, (rows, columns) of `resolution` metres, row 0 on top.

    The 640×640 raster is resampled to the picture's true width and height, which undoes its stretch.

    Raises:
        BadInput: the picture is missing or unreadable.
    """
    file = Path(data_dir) / "landmines" / "images" / f"{entry.name}.jpg"
    grey = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) if file.is_file() else None
    if grey is None:
        raise BadInput(f"{file}: not a readable picture, though the index names it")
    size = (round(entry.width / resolution), round(entry.height / resolution))
    shrinks = size[0] < grey.shape[1]
    way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    metric = np.asarray(cv2.resize(grey.astype(np.float32), size, interpolation=way), np.float32)
    soil = outside_boxes(entry, resolution, metric.shape)
    detail = metric - _trend(metric, soil, resolution)
    spread = float(detail[soil].std())
    if spread < 1e-3:
        raise BadInput(f"{file}: has no texture at all; remove it from the index")
    detail -= np.median(detail[soil])
    kelvin = np.clip(detail * (TEXTURE_KELVIN / spread), -CLIP_KELVIN, CLIP_KELVIN)
    return np.asarray(kelvin, np.float32)


def _trend(metric: NDArray[np.float32], soil: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Gaussian mean over soil only, so that a mine's warmth is not taken for trend; on a coarse lattice."""
    step = max(1, round(0.05 / resolution))
    small = (max(2, metric.shape[1] // step), max(2, metric.shape[0] // step))
    weight = soil.astype(np.float32)
    sigma = TREND_M / (resolution * step)
    blurred = [
        cv2.GaussianBlur(cv2.resize(layer, small, interpolation=cv2.INTER_AREA), (0, 0), sigma)
        for layer in (metric * weight, weight)
    ]
    trend = np.asarray(blurred[0], np.float32) / np.maximum(np.asarray(blurred[1], np.float32), np.float32(1e-3))
    size = (metric.shape[1], metric.shape[0])
    return np.asarray(cv2.resize(trend, size, interpolation=cv2.INTER_LINEAR), np.float32)


def outside_boxes(
    entry: Entry, resolution: float, shape: tuple[int, ...], margin: float = 0.03
) -> NDArray[np.bool_]:
    """True (rows, columns) where the metric picture shows no labelled box, each grown by `margin` metres."""
    free = np.ones(shape[:2], dtype=bool)
    for cx, cy, w, h in entry.boxes:
        rows = slice(
            max(0, int((cy - h / 2 - margin) / resolution)), int((cy + h / 2 + margin) / resolution) + 1
        )
        columns = slice(
            max(0, int((cx - w / 2 - margin) / resolution)), int((cx + w / 2 + margin) / resolution) + 1
        )
        free[rows, columns] = False
    return free
