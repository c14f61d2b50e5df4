"""The map as others read it: a PGM picture with a YAML beside it, in the form of map_server (trinary mode)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput


class Grid(Protocol):
    """What is saved: a `SurveyGrid`, or a `PictureGrid`."""

    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def resolution(self) -> float: ...
    @property
    def seen(self) -> NDArray[np.bool_]: ...
    @property
    def occupied(self) -> NDArray[np.bool_]: ...


FREE, OCCUPIED, UNKNOWN = 254, 0, 205
FREE_THRESHOLD, OCCUPIED_THRESHOLD = 0.196, 0.65


@dataclass(frozen=True, eq=False)
class StoredMap:
    """Rasters (rows, columns) with row 0 at the lowest y; resolution in metres; origin x, y, heading in map."""

    seen: NDArray[np.bool_]
    occupied: NDArray[np.bool_]
    resolution: float
    origin: tuple[float, float, float]


def save(grid: Grid, yaml_path: str | Path) -> None:
    """Writes `<name>.yaml` and `<name>.pgm`: occupied black, seen free ground white, the rest grey."""
    file = Path(yaml_path)
    occupied = grid.occupied
    picture = np.full(grid.shape, UNKNOWN, np.uint8)
    picture[grid.seen] = FREE
    picture[occupied] = OCCUPIED
    head = f"P5\n{grid.shape[1]} {grid.shape[0]}\n255\n".encode()
    file.parent.mkdir(parents=True, exist_ok=True)
    file.with_suffix(".pgm").write_bytes(head + picture[::-1].tobytes())
    file.write_text(
        f"image: {file.with_suffix('.pgm').name}\nmode: trinary\nresolution: {grid.resolution:g}\n"
        f"origin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: {OCCUPIED_THRESHOLD}\nfree_thresh: {FREE_THRESHOLD}\n",
        encoding="utf-8",
    )


def read(yaml_path: str | Path) -> StoredMap:
    """Reads a map of map_server. Raises BadInput (file, key, what is expected)."""
    file = Path(yaml_path)
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{file}: the map cannot be read: {error}") from error
    pairs = (line.split("#")[0].partition(":") for line in lines)
    values = {key.strip(): value.strip() for key, _, value in pairs if value.strip()}
    for key in ("image", "resolution", "origin"):
        if key not in values:
            raise BadInput(f"{file}: {key}: missing; a map of map_server has image, resolution and origin")
    try:
        resolution = float(values["resolution"])
        x, y, heading = (float(part) for part in values["origin"].strip("[] ").split(","))
        negate = bool(int(values.get("negate", "0")))
        occupied_from = float(values.get("occupied_thresh", OCCUPIED_THRESHOLD))
        free_below = float(values.get("free_thresh", FREE_THRESHOLD))
    except ValueError as error:
        raise BadInput(f"{file}: {error}; numbers are expected, and origin as [x, y, heading]") from error
    numbers = {"origin": (x, y, heading), "occupied_thresh": (occupied_from,), "free_thresh": (free_below,)}
    for key, parts in numbers.items():
        if not all(map(math.isfinite, parts)):
            raise BadInput(f"{file}: {key}: finite numbers are expected, got {values[key]}")
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise BadInput(f"{file}: resolution: a finite length above 0 is expected, got {resolution:g}")
    image = file.parent / values["image"].strip("\"'")
    picture = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE) if image.is_file() else None
    if picture is None:
        raise BadInput(f"{image}: not a readable picture, though {file.name} names it")
    shade = picture[::-1].astype(np.float32) / 255.0
    probability = shade if negate else 1.0 - shade
    occupied = probability > occupied_from
    return StoredMap(occupied | (probability < free_below), occupied, resolution, (x, y, heading))
