"""Maps as others read and write them: a picture with a YAML beside it, in the form of ROS's map_server.

https://docs.ros.org/en/noetic/api/map_server/html and nav2's map_io.cpp say what the keys mean.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import yaml
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.mapping.map_picture import Shades, read_shades
from rover.plain_file import plain_file


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
TRUTHS = {"0": False, "false": False, "1": True, "true": True}

# A map turned by so little that no corner of it moves by more than this share of a cell is read as not turned.
MAX_TURN_CELLS = 0.01


@dataclass(frozen=True, eq=False)
class StoredMap:
    """Rasters (rows, columns) with row 0 at the lowest y; resolution in metres; origin x, y in map.

    `seen` holds free and occupied cells. `doubtful` are free by the file's own threshold, though they have the grey
    that map savers write for unknown.
    """

    seen: NDArray[np.bool_]
    occupied: NDArray[np.bool_]
    doubtful: NDArray[np.bool_]
    resolution: float
    origin: tuple[float, float]


def save(grid: Grid, yaml_path: str | Path) -> None:
    """Writes `<name>.yaml` and `<name>.pgm`: occupied black, seen free ground white, the rest grey."""
    file = Path(yaml_path)
    file.parent.mkdir(parents=True, exist_ok=True)
    for name, content in map_files(grid, file.stem).items():
        (file.parent / name).write_bytes(content)


def map_files(grid: Grid, stem: str) -> dict[str, bytes]:
    """The content of `<stem>.pgm` and `<stem>.yaml`, by name."""
    occupied = grid.occupied
    picture = np.full(grid.shape, UNKNOWN, np.uint8)
    picture[grid.seen] = FREE
    picture[occupied] = OCCUPIED
    head = f"P5\n{grid.shape[1]} {grid.shape[0]}\n255\n".encode()
    text = (
        f"image: {stem}.pgm\nmode: trinary\nresolution: {grid.resolution:g}\n"
        f"origin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: {OCCUPIED_THRESHOLD}\nfree_thresh: {FREE_THRESHOLD}\n"
    )
    return {f"{stem}.pgm": head + picture[::-1].tobytes(), f"{stem}.yaml": text.encode()}


def read(yaml_path: str | Path) -> StoredMap:
    """Reads a map of map_server. Raises BadInput (file, key, what is expected)."""
    file = Path(yaml_path)
    values = _entries(file)
    for key in ("image", "resolution", "origin"):
        if values.get(key) is None:
            raise BadInput(f"{file}: {key}: missing; a map of map_server has image, resolution and origin")
    resolution = _number(file, "resolution", values["resolution"])
    if not resolution > 0.0:
        raise BadInput(f"{file}: resolution: a finite length above 0 is expected, got {resolution:g}")
    origin = values["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise BadInput(f"{file}: origin: [x, y, yaw] is expected, got {origin}")
    x, y, yaw = (_number(file, "origin", value) for value in origin)
    occupied_from = _share(file, "occupied_thresh", values, OCCUPIED_THRESHOLD)
    free_below = _share(file, "free_thresh", values, FREE_THRESHOLD)
    mode = str(values.get("mode", "trinary")).lower()
    if mode not in ("trinary", "scale", "raw"):
        raise BadInput(f"{file}: mode: trinary, scale or raw is expected, got {values['mode']}")
    if mode != "raw" and not free_below > 0.0:
        raise BadInput(
            f"{file}: free_thresh: with {free_below:g} no cell is free; a mask of speeds or costs is no map to plan on"
        )
    if mode != "raw" and free_below > occupied_from:
        raise BadInput(f"{file}: free_thresh: {free_below:g} lies above occupied_thresh, {occupied_from:g}")
    negate = _truth(file, "negate", values.get("negate", 0))
    if not isinstance(values["image"], str):
        raise BadInput(f"{file}: image: the name of a picture is expected, got {values['image']}")
    shades = read_shades(file.parent / values["image"])
    rows, columns = shades.shade.shape
    if abs(math.remainder(yaw, math.tau)) * math.hypot(rows, columns) > MAX_TURN_CELLS:
        raise BadInput(f"{file}: origin: the map is turned by {yaw:g} rad; only maps with yaw 0 can be read")
    if mode == "raw":
        seen, occupied = _raw(shades, free_below)
    else:
        seen, occupied = _thresholds(shades, negate, occupied_from, free_below, graded=mode == "scale")
    grey = np.abs(shades.shade * 255.0 - UNKNOWN) < 0.5
    doubtful = grey & seen & ~occupied if mode != "raw" else np.zeros_like(seen)
    return StoredMap(seen[::-1], occupied[::-1], doubtful[::-1], resolution, (x, y))


def _thresholds(
    shades: Shades, negate: bool, occupied_from: float, free_below: float, graded: bool
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(seen, occupied). What lies between the thresholds is unknown; where it is `graded` it costs, and is no way."""
    occupancy = shades.shade if negate else 1.0 - shades.shade
    occupied = (occupancy >= free_below if graded else occupancy > occupied_from) & shades.opaque
    free = (occupancy < free_below) & shades.opaque
    return occupied | free, occupied


def _raw(shades: Shades, free_below: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(seen, occupied) of a picture that holds occupancy in per cent; above 100 nothing is known."""
    percent = np.rint(shades.shade * 255.0)
    seen = (percent <= 100.0) & shades.opaque
    return seen, seen & (percent >= 100.0 * free_below)


def _entries(file: Path) -> dict[str, Any]:
    try:
        values = yaml.safe_load(plain_file(file).read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise BadInput(f"{file}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise BadInput(f"{file}: not a text file") from error
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise BadInput(f"{file}: {line}not valid YAML: {error.problem or error.context}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise BadInput(f"{file}: not valid YAML: {' '.join(str(error).split())}") from error
    if not isinstance(values, dict):
        raise BadInput(f"{file}: `image: …`, `resolution: …` and `origin: …` are expected")
    return values


def _number(file: Path, key: str, value: object) -> float:
    number = math.nan
    # YAML 1.1 takes 1e-6 and -nan for text.
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        with contextlib.suppress(ValueError, OverflowError):
            number = float(value)
    if not math.isfinite(number):
        raise BadInput(f"{file}: {key}: finite numbers are expected, got {value}")
    return number


def _share(file: Path, key: str, values: dict[str, Any], default: float) -> float:
    share = _number(file, key, values.get(key, default))
    if not 0.0 <= share <= 1.0:
        raise BadInput(f"{file}: {key}: must lie between 0 and 1, not {share:g}")
    return share


def _truth(file: Path, key: str, value: object) -> bool:
    truth = TRUTHS.get(str(value).lower())
    if truth is None:
        raise BadInput(f"{file}: {key}: 0, 1, true or false is expected, got {value}")
    return truth
