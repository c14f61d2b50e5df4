"""Maps to plan on: circles in a rectangle, grids of blocked cells, and the files that hold them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import rover_native
from numpy.typing import ArrayLike, NDArray

from rover.errors import BadInput
from rover.mapping import map_server
from rover.plain_file import plain_file
from rover.toml_table import Table

# Coordinates beyond this lose the millimetre.
MAX_COORDINATE_M = 1e7
# A side below this is a slip of the unit.
MIN_SIDE_M = 1e-4
# Kinds of MovingAI maps with one letter of terrain for each cell.
MOVINGAI_TYPES = ("octile", "tile")

Unknown = Literal["blocked", "free"]
"""What ground of which a map says nothing counts as."""


class Field:
    """What the planner asks of a map; metres. Bounds count as walls for the robot's radius."""

    native: rover_native.NativeField

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, y_min, x_max, y_max)."""
        return self.native.bounds

    def clearance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Distance (N,) of each of the (N, 2) points to the nearest obstacle or wall; not positive inside one."""
        return self.native.clearance(np.asarray(points, dtype=np.float64).reshape(-1, 2))

    def segment_clear(self, a: tuple[float, float], b: tuple[float, float], radius: float) -> bool:
        """True when a disc of `radius` swept from a to b stays inside the bounds and touches nothing."""
        return self.native.segment_clear((float(a[0]), float(a[1])), (float(b[0]), float(b[1])), float(radius))


class CircleField(Field):
    """A rectangle [0, width] × [0, height] with circular obstacles (x, y, radius): checks are exact."""

    def __init__(self, width: float, height: float, obstacles: Sequence[Sequence[float]] = ()) -> None:
        for name, value in (("width", width), ("height", height)):
            if not (math.isfinite(value) and value > 0.0):
                raise BadInput(f"the field's {name} must be a positive number of metres, not {value}")
            if not MIN_SIDE_M <= value <= MAX_COORDINATE_M:
                raise BadInput(f"the field's {name} must be {MIN_SIDE_M:g} to {MAX_COORDINATE_M:g} m, not {value:g}")
        for index, circle in enumerate(obstacles):
            if len(circle) != 3 or not all(abs(v) <= MAX_COORDINATE_M for v in circle) or circle[2] < 0.0:
                raise BadInput(f"obstacle {index + 1} must be [x, y, radius] with radius >= 0, not {list(circle)}")
        self.width, self.height = float(width), float(height)
        self.obstacles = np.array(obstacles, dtype=np.float64).reshape(-1, 3)
        self.native = rover_native.NativeField.circles(self.width, self.height, self.obstacles)

    @classmethod
    def load(cls, path: str | Path) -> CircleField:
        """From TOML with `width`, `height` and `obstacles = [[x, y, radius], …]`. Raises BadInput."""
        table = Table.of_file(Path(path)).only("width", "height", "obstacles")
        width, height = (table.number(key, MIN_SIDE_M, MAX_COORDINATE_M) for key in ("width", "height"))
        try:
            return cls(
                width, height, table.rows("obstacles", ("x", "y", "radius"), -MAX_COORDINATE_M, MAX_COORDINATE_M)
            )
        except BadInput as error:
            raise BadInput(f"{path}: {error}") from error


class GridField(Field):
    """Blocked cells. Row 0 lies at `origin`'s y, row index grows with y; a cell is a full square of ground."""

    def __init__(self, blocked: ArrayLike, resolution: float, origin: tuple[float, float] = (0.0, 0.0)) -> None:
        cells = np.asarray(blocked)
        if cells.ndim != 2 or cells.size == 0:
            raise BadInput(f"a grid map needs rows and columns, not shape {cells.shape}")
        if not (math.isfinite(resolution) and resolution > 0.0):
            raise BadInput(f"the resolution must be a positive number of metres per cell, not {resolution}")
        if not (resolution >= MIN_SIDE_M and resolution * max(cells.shape) <= MAX_COORDINATE_M):
            raise BadInput(f"cells of {resolution:g} m make no map of {MIN_SIDE_M:g} to {MAX_COORDINATE_M:g} m")
        if not all(abs(value) <= MAX_COORDINATE_M for value in origin):
            raise BadInput(f"the map's origin must be finite and within {MAX_COORDINATE_M:g} m, not {origin}")
        # Truth values are taken as they are: the native map has its own copy, and maps are changed often.
        self.blocked = np.ascontiguousarray(cells if cells.dtype == np.bool_ else cells != 0)
        self.resolution = float(resolution)
        self.origin = (float(origin[0]), float(origin[1]))
        self.native = rover_native.NativeField.grid(self.blocked.view(np.uint8), self.resolution, *self.origin)

    @classmethod
    def load_movingai(cls, path: str | Path, resolution: float = 1.0) -> GridField:
        """From a MovingAI .map: x is the column, y the row from the top; `.`, `G` and `S` are free. Raises BadInput."""
        path = Path(path)
        lines = _text(path).splitlines()
        header: dict[str, str] = {}
        first = 0
        for first, line in enumerate(lines, start=1):  # noqa: B007
            words = line.split()
            if words == ["map"]:
                break
            if len(words) == 2:
                header[words[0]] = words[1]
        else:
            raise BadInput(f"{path}: not a MovingAI map: no line `map`")
        kind = header.get("type", "octile")
        if kind not in MOVINGAI_TYPES:
            raise BadInput(f"{path}: a map of type {kind} can't be read; its cells are not those of type octile")
        try:
            width, height = int(header["width"]), int(header["height"])
        except (KeyError, ValueError) as error:
            raise BadInput(f"{path}: needs `width N` and `height N` before `map`") from error
        if width < 1 or height < 1:
            raise BadInput(f"{path}: width and height must be at least 1, not {width} and {height}")
        rows = lines[first : first + height]
        if len(rows) < height or any(len(row) != width for row in rows):
            raise BadInput(f"{path}: expected {height} rows of {width} cells after `map`")
        cells = np.frombuffer("".join(rows).encode("latin-1", "replace"), dtype=np.uint8).reshape(height, width)
        return cls(~np.isin(cells, np.frombuffer(b".GS", dtype=np.uint8)), resolution)

    @classmethod
    def load_map_server(
        cls, path: str | Path, unknown: Unknown = "blocked", tell: Callable[[str], None] = lambda _: None
    ) -> GridField:
        """From a map_server .yaml and its picture; `unknown` ground is blocked or free, and `tell` hears how much.

        A file's free_thresh may call the grey free that map savers write for unknown: that grey goes by `unknown`, too.
        Raises BadInput.
        """
        path = Path(path)
        stored = map_server.read(path)
        doubtful = int(stored.doubtful.sum())
        if unknown == "free":
            blocked = stored.occupied
            tell(f"{path}: {int((~stored.seen).sum()) + doubtful} cells look unknown and count as free")
        else:
            blocked = ~stored.seen | stored.occupied | stored.doubtful
            if doubtful:
                grey = f"{doubtful} cells have the grey of unknown ground ({map_server.UNKNOWN})"
                tell(f"{path}: {grey} and count as blocked, though the file's free_thresh makes them free")
        return _named(path, cls, blocked, stored.resolution, stored.origin)


def _named(path: Path, kind: type[GridField], blocked: NDArray[np.bool_], *where: Any) -> GridField:
    """The map, or what is wrong with it under the file's name."""
    try:
        return kind(blocked, *where)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error


def load_field(
    path: str | Path,
    resolution: float = 1.0,
    unknown: Unknown = "blocked",
    tell: Callable[[str], None] = lambda _: None,
) -> Field:
    """The map in a file, by its ending: .toml (circles), .yaml/.yml (map_server), .map (MovingAI).

    `resolution`: metres per cell of a .map. `unknown`, `tell`: of a .yaml, see `GridField`. Raises BadInput.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".toml":
        return CircleField.load(path)
    if suffix in (".yaml", ".yml"):
        return GridField.load_map_server(path, unknown, tell)
    if suffix == ".map":
        return GridField.load_movingai(path, resolution)
    raise BadInput(f"{path}: a map must end in .toml, .yaml or .map")


def _text(path: Path) -> str:
    try:
        return plain_file(path).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror or error}") from error
