"""Builds the ground of a simulated mission: temperature, height, obstacles, mines, from a mission and a seed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

from rover_hil.ground.layer import Layer
from rover_hil.ground.litter import lay_litter
from rover_hil.ground.mine import Mine
from rover_hil.ground.mosaic import choose_cuttings, lay_cutting, lay_soil, measured_contrast
from rover_hil.ground.pictures import TEXTURE_KELVIN, read_index
from rover_hil.ground.placement import Circle, Point, Site, check_known, place
from rover_hil.ground.plates import lay_plates, plate_temperature
from rover_hil.ground.random_placement import place_at_random
from rover_hil.ground.raster import Grid
from rover_hil.ground.signature import (
    MINE_RADIUS_M,
    SURFACE_MINE_HEIGHT_M,
    SURFACE_MINE_RADII_M,
    daily_contrasts,
    lay_signature,
)
from rover_hil.ground.soils import soil_named
from rover_hil.ground.texture import lay_patches, roughness, soil_texture
from rover_hil.ground.things import Hour, at_hour, lay_grass, lay_pebbles, lay_rock
from rover_hil.ground.unfriendly import LITTER, MINES, lay_soil_with_causes, lay_weather
from rover_hil.ground.varied_mines import lay_varied_mines
from rover_hil.world import world_of

if TYPE_CHECKING:
    from rover.mission.config import Mission

# Metres of ground around the area, so that the camera sees beyond the border.
MARGIN_M = 1.6
FINE_RESOLUTION_M = 0.005
COARSE_RESOLUTION_M = 0.01
# A raster larger than this is laid at the coarse resolution.
MAX_FINE_CELLS = 4_000_000
# 100 MB a raster: fields up to about 46 x 46 m.
MAX_CELLS = 25_000_000


@dataclass(frozen=True)
class Ground:
    """The ground at one hour. Rasters (rows, columns), row 0 at the lowest y; see `raster.Grid`.

    `obstacles` (n, 4): x, y, radius, height in metres; `obstacle_kinds` says "rock" or "grass" for each.
    """

    temperature: NDArray[np.float32]
    height: NDArray[np.float32]
    grid: Grid
    obstacles: NDArray[np.float64]
    obstacle_kinds: tuple[str, ...]
    mines: tuple[Mine, ...]
    soil: str
    hour: float
    area: tuple[float, float]
    seed: int
    texture: dict[str, Any] = field(default_factory=dict)
    layers: tuple[Layer, ...] = ()

    @property
    def origin_x(self) -> float:
        """x of the raster's outer corner, m."""
        return self.grid.origin_x

    @property
    def origin_y(self) -> float:
        """y of the raster's outer corner, m."""
        return self.grid.origin_y

    @property
    def resolution(self) -> float:
        """Cell size, m."""
        return self.grid.resolution

    def truth(self) -> dict[str, Any]:
        """What lies where, ready for JSON."""
        shapes = [
            {"x": x, "y": y, "radius": r, "height": h, "kind": kind}
            for (x, y, r, h), kind in zip(self.obstacles.tolist(), self.obstacle_kinds, strict=True)
        ]
        return {
            "area": {"width": self.area[0], "height": self.area[1]},
            "hour": self.hour,
            "soil": self.soil,
            "seed": self.seed,
            "mines": [
                {
                    "id": m.id,
                    "x": m.x,
                    "y": m.y,
                    "radius": m.radius,
                    "depth": m.depth,
                    "kind": m.kind,
                    "contrast_k": m.contrast_k,
                }
                for m in self.mines
            ],
            "obstacles": shapes,
            "grass": [shape for shape in shapes if shape["kind"] == "grass"],
            "texture": self.texture,
        }


def site_of(mission: Mission) -> Site:
    """The constraints that a mission puts on placement."""
    return Site(
        width=float(mission.area.width),
        height=float(mission.area.height),
        launch=(float(mission.launch.pose.x), float(mission.launch.pose.y)),
        goals=tuple((float(x), float(y)) for x, y in mission.goals),
        known=tuple((float(x), float(y), float(r)) for x, y, r in mission.area.obstacles),
        bare=tuple((x, y, mission.plates.radius) for x, y in mission.plates.places),
    )


def grid_of(width: float, height: float) -> Grid:
    """The raster over an area with its margin.

    Raises:
        BadInput: the area is too large to simulate.
    """
    outer_width, outer_height = width + 2 * MARGIN_M, height + 2 * MARGIN_M
    fine = outer_width * outer_height / FINE_RESOLUTION_M**2 <= MAX_FINE_CELLS
    resolution = FINE_RESOLUTION_M if fine else COARSE_RESOLUTION_M
    if outer_width * outer_height / resolution**2 > MAX_CELLS:
        raise BadInput(f"area: {width:g} x {height:g} m is too large to simulate; stay within 46 x 46 m")
    columns, rows = int(np.ceil(outer_width / resolution)), int(np.ceil(outer_height / resolution))
    return Grid(-MARGIN_M, -MARGIN_M, resolution, columns, rows)


def build(mission: Mission, seed: int, data_dir: str | Path | None = None) -> Ground:
    """The ground of a mission; with `data_dir`, laid from the real pictures in `<data_dir>/landmines`.

    The same mission and seed give the same bytes.

    Raises:
        BadInput: unknown soil, a field too full, a goal inside a known obstacle, missing pictures.
    """
    site = site_of(mission)
    check_known(site)
    soil = soil_named(mission.field.soil)
    world = world_of(mission)
    hour = float(mission.time_of_day_s) / 3600.0
    now = at_hour(soil, hour)
    grid = grid_of(site.width, site.height)
    # One independent stream per concern: more rocks do not change the soil's texture.
    placing, looks, surfacing = (np.random.default_rng([seed, stream]) for stream in range(3))

    radii, heights, kinds = _draw_obstacles(mission.field.rocks, mission.field.grass, placing)
    height = roughness(grid, surfacing)
    depths = (*(0.0,) * mission.field.surface_mines, *(float(d) for d in mission.field.buried_mine_depths))
    at_random = mission.field.placement == "random"
    layout = (place_at_random if at_random else place)(site, radii, len(depths), placing)
    clutter = lay_soil_with_causes(world, grid, soil, hour, seed) if data_dir is None else None
    if data_dir is None:
        temperature = soil_texture(grid, surfacing) + np.float32(now.soil)
        lay_patches(temperature, grid, surfacing)
        if clutter is not None:
            temperature = clutter.temperature.copy()
        lay_pebbles(temperature, height, grid, now, surfacing)
        litter, varied = world.sizes("things.litter"), world.sizes("things.mines")
        if litter is not None:
            lay_litter(temperature, height, grid, now, litter, np.random.default_rng([seed, LITTER]))
        if varied is None:
            mines = _lay_mines(temperature, height, grid, mission.field.soil, hour, layout.mines, depths, looks)
        else:
            rng = np.random.default_rng([seed, MINES])
            mines = lay_varied_mines(temperature, height, grid, soil, hour, layout.mines, depths, varied, rng)
        texture: dict[str, Any] = {"kind": "synthetic"}
    else:
        kinds_wanted = tuple(depth == 0.0 for depth in depths)
        temperature, mines, texture = _lay_pictures(data_dir, grid, layout.mines, kinds_wanted, looks)
        temperature += np.float32(now.soil)
        for mine in mines:
            if mine.kind == "surface":
                lay_casing(height, grid, (mine.x, mine.y, mine.radius))

    known_heights = placing.uniform(0.15, 0.25, size=len(site.known))
    obstacles = np.array(
        [
            *((x, y, r, h) for (x, y, r), h in zip(site.known, known_heights, strict=True)),
            *((x, y, r, h) for (x, y, r), h in zip(layout.obstacles, heights, strict=True)),
        ],
        dtype=np.float64,
    ).reshape(-1, 4)
    all_kinds = ("rock",) * len(site.known) + kinds
    lay_obstacles(temperature, height, grid, obstacles, all_kinds, now, looks)
    lay_plates(temperature, height, grid, mission.plates, plate_temperature(hour))
    seconds = math.ceil(mission.max_duration_s)
    layers = lay_weather(world, temperature, grid, (site.width, site.height), soil, hour, seconds, seed, clutter)
    return Ground(
        temperature=temperature,
        height=height,
        grid=grid,
        obstacles=obstacles,
        obstacle_kinds=all_kinds,
        mines=mines,
        soil=mission.field.soil,
        hour=hour,
        area=(site.width, site.height),
        seed=seed,
        texture=texture,
        layers=layers,
    )


def _draw_obstacles(
    rocks: int, grass: int, rng: np.random.Generator
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[str, ...]]:
    """Radii, heights (m) and kinds; rocks first."""
    radii = (*rng.uniform(0.06, 0.18, size=rocks).tolist(), *rng.uniform(0.08, 0.15, size=grass).tolist())
    heights = (*rng.uniform(0.12, 0.25, size=rocks).tolist(), *rng.uniform(0.08, 0.20, size=grass).tolist())
    return radii, heights, ("rock",) * rocks + ("grass",) * grass


def lay_obstacles(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    obstacles: NDArray[np.float64],
    kinds: tuple[str, ...],
    now: Hour,
    rng: np.random.Generator,
) -> None:
    """Lay every rock and tuft, in place."""
    for (x, y, r, h), kind in zip(obstacles.tolist(), kinds, strict=True):
        (lay_rock if kind == "rock" else lay_grass)(temperature, height, grid, (x, y, r, h), now, rng)


def _lay_mines(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    soil: str,
    hour: float,
    centres: tuple[Point, ...],
    depths: tuple[float, ...],
    rng: np.random.Generator,
) -> tuple[Mine, ...]:
    """Lay the signature of every mine; surface mines also stand out of the soil. In place."""
    if not depths:
        return ()
    day = daily_contrasts(soil, depths)
    mines = []
    for i, ((x, y), depth) in enumerate(zip(centres, depths, strict=True)):
        # Surface casings differ in size; buried ones are the reference disc.
        radius = float(rng.uniform(*SURFACE_MINE_RADII_M)) if depth == 0.0 else MINE_RADIUS_M
        distance = day.contrast.radius * (radius / MINE_RADIUS_M)
        profile = day.profile(depth, hour, day.contrast.radius)
        lay_signature(temperature, grid, (x, y), distance, profile)
        if depth == 0.0:
            lay_casing(height, grid, (x, y, radius))
        peak = float(profile[np.argmax(np.abs(profile))])
        kind = "surface" if depth == 0.0 else "buried"
        mines.append(Mine(i + 1, x, y, radius, depth, kind, round(peak, 4)))
    return tuple(mines)


def _lay_pictures(
    data_dir: str | Path,
    grid: Grid,
    centres: tuple[Point, ...],
    surface_flags: tuple[bool, ...],
    rng: np.random.Generator,
) -> tuple[NDArray[np.float32], tuple[Mine, ...], dict[str, Any]]:
    """Real texture (K about 0), the labelled mines that were laid at `centres`, and where it all came from.

    A mission's surface mines become labelled surface mines, its buried ones labelled buried mines, each with the
    depth that the set's index gives it.
    """
    entries = read_index(data_dir)
    deviation, names = lay_soil(data_dir, entries, grid, rng)
    # Cuttings may not overlap: each has half of the way to its nearest neighbour.
    spaces = [
        min([0.5 * math.dist(a, b) for j, b in enumerate(centres) if j != i], default=math.inf)
        for i, a in enumerate(centres)
    ]
    chosen = choose_cuttings(entries, surface_flags, spaces, rng)
    mines = []
    for i, (cutting, centre, space) in enumerate(zip(chosen, centres, spaces, strict=True)):
        lay_cutting(deviation, data_dir, cutting, grid, centre, space, rng)
        contrast = measured_contrast(deviation, grid, centre, cutting.half)
        depth = cutting.entry.depth
        # A box on the surface frames the casing; a buried one frames a signature wider than the mine.
        radius = float(np.clip(0.25 * (cutting.box[2] + cutting.box[3]), 0.05, 0.08)) if depth == 0 else MINE_RADIUS_M
        kind = "surface" if depth == 0.0 else "buried"
        mines.append(Mine(i + 1, *centre, radius, depth, kind, round(contrast, 4)))
    source = {
        "kind": "real texture, assumed scale",
        "soil_rms_kelvin": TEXTURE_KELVIN,
        "pictures": names,
        "mine_pictures": [cutting.entry.name for cutting in chosen],
    }
    return deviation, tuple(mines), source


def lay_casing(height: NDArray[np.float32], grid: Grid, circle: Circle) -> None:
    """Raise the ground to the lid of a mine that stands proud, in place."""
    x, y, r = circle
    window = grid.window((x, y), r)
    inside = np.hypot(*grid.offsets(window, (x, y))) < r
    height[window] = np.where(inside, np.float32(SURFACE_MINE_HEIGHT_M), height[window])
