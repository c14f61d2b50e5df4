"""The labelled pictures of the landmine set as they lie on disk, each once, with what is known of every box.

The set holds some pictures several times with other labels (`zone1_B_0014_2`): their boxes are joined. A zone has one
mine of its own, and `depth_cm` is that one's; from a height neighbouring zones' mines come into view, whose depth the
index does not tell. Such boxes are mines of unknown kind.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

# A zone's own mine is the box nearest to the middle; from LOW_HEIGHT on only within MIDDLE of the picture's width.
LOW_HEIGHT, MIDDLE = 5.0, 0.31
# Boxes of copies of one picture nearer than this, pixels, are the same mine.
SAME_PX = 20.0
UNTOLD_ZONE = "6"


@dataclass(frozen=True)
class Box:
    """A labelled mine: centre, width and height in pixels; kind 'surface', 'buried' or '' where it is not known."""

    x: float
    y: float
    width: float
    height: float
    kind: str

    @property
    def side(self) -> float:
        """Side of the square of the same area."""
        return math.sqrt(self.width * self.height)


@dataclass(frozen=True, eq=False)
class Record:
    """One picture of the set. grey: (h, w) as on disk; height: of the camera, metres, unreliable below 3.

    depth_cm: of the zone's own mine, nan where it is not told. centre_temp_c: at the middle of the picture.
    """

    name: str
    zone: str
    session: str
    height: float
    boxes: tuple[Box, ...]
    grey: NDArray[np.uint8]
    depth_cm: float = math.nan
    centre_temp_c: float = math.nan


def read_records(data: Path) -> list[Record]:
    """Every picture once, in the order of the index. Raises BadInput where index, labels or pictures are missing."""
    folder = data / "landmines"
    index = folder / "index.csv"
    if not index.is_file():
        raise BadInput(f"{index}: not found; --data must name the folder that holds landmines/index.csv")
    copies: dict[str, list[dict[str, str]]] = {}
    with index.open(newline="") as file:
        for row in csv.DictReader(file):
            copies.setdefault("_".join(row["name"].split("_")[:3]), []).append(row)
    return [_record(folder, name, rows) for name, rows in copies.items()]


def _record(folder: Path, name: str, rows: list[dict[str, str]]) -> Record:
    first = rows[0]
    file = folder / "images" / f"{first['name']}.jpg"
    grey = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) if file.is_file() else None
    if grey is None:
        raise BadInput(f"{file}: not a readable picture, though the index names it")
    rows_px, columns_px = grey.shape
    boxes: list[tuple[float, float, float, float]] = []
    for row in rows:
        for x, y, w, h in _labels(folder / "labels" / f"{row['name']}.txt"):
            box = (x * columns_px, y * rows_px, w * columns_px, h * rows_px)
            if all(max(abs(box[0] - other[0]), abs(box[1] - other[1])) >= SAME_PX for other in boxes):
                boxes.append(box)
    height = float(first["height_m"])
    depth = first["depth_cm"].strip()
    kind = "" if not depth or first["zone"] == UNTOLD_ZONE else "surface" if float(depth) == 0.0 else "buried"
    away = [math.hypot(x - columns_px / 2, y - rows_px / 2) for x, y, _, _ in boxes]
    own = [d == min(away) and (height < LOW_HEIGHT or d < MIDDLE * columns_px) for d in away]
    return Record(
        name,
        first["zone"],
        first["session"],
        height,
        tuple(Box(*box, kind if mine else "") for box, mine in zip(boxes, own, strict=True)),
        np.asarray(grey, np.uint8),
        float(depth) if kind else math.nan,
        float(first["centre_temp_c"] or "nan"),
    )


def _labels(file: Path) -> Iterator[tuple[float, float, float, float]]:
    try:
        lines = file.read_text().splitlines()
    except OSError as error:
        raise BadInput(f"{file}: the labels cannot be read ({error.strerror})") from error
    for line in lines:
        if line.strip():
            try:
                _, x, y, w, h = (float(part) for part in line.split())
            except ValueError as error:
                raise BadInput(f"{file}: {line!r}: five numbers are expected") from error
            yield x, y, w, h
