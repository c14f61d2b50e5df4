"""The ground of a mission as a plot: surface temperature over the map, and what lies in it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.patheffects import withStroke
from rover.capture.radiometry import ZERO_CELSIUS

from rover_hil.ground.field import Ground
from rover_hil.ground.mine import Mine

# The colours span the raster between these percentiles: one hot stone must not make the soil look flat.
PERCENTILES = (2.0, 99.5)
LONGER_SIDE_INCH = 8.0
MINE_MARK_M = 0.12
LABEL_GAP_M = 0.03
AREA, MINE, ROCK, GRASS = "white", "cyan", "deepskyblue", "lime"


def figure(ground: Ground, marks: bool = True) -> Figure:
    """The plot in metres of map, y up; marks: the area, mines and obstacles, each with a label or in the legend."""
    width, height = ground.grid.columns * ground.resolution, ground.grid.rows * ground.resolution
    unit = LONGER_SIDE_INCH / max(width, height)
    made = Figure(figsize=(width * unit + 2.2, height * unit + 1.2), layout="constrained")
    axes = made.add_subplot()
    celsius = ground.temperature - np.float32(ZERO_CELSIUS)
    low, high = np.percentile(celsius, PERCENTILES)
    left, bottom = ground.origin_x, ground.origin_y
    extent = (left, left + width, bottom, bottom + height)
    shown = axes.imshow(celsius, cmap="inferno", origin="lower", vmin=low, vmax=high, extent=extent)
    made.colorbar(shown, ax=axes, label="surface temperature, °C", shrink=0.8)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    hour = f"{int(ground.hour):02d}:{round(ground.hour % 1 * 60):02d}"
    axes.set_title(f"Simulated ground: {ground.soil}, {hour}, seed {ground.seed}, {ground.texture.get('kind', '')}")
    if marks:
        _mark(axes, ground)
        made.legend(loc="outside lower center", ncols=4, facecolor="dimgray", labelcolor="white", framealpha=1.0)
    return made


def _mark(axes: Axes, ground: Ground) -> None:
    axes.add_patch(Rectangle((0.0, 0.0), *ground.area, fill=False, edgecolor=AREA, label="area of the mission"))
    known: set[str] = set()

    def circle(x: float, y: float, radius: float, colour: str, kind: str) -> None:
        label = None if kind in known else kind
        known.add(kind)
        axes.add_patch(Circle((x, y), radius, fill=False, edgecolor=colour, linewidth=1.2, label=label))

    for (x, y, radius, _), kind in zip(ground.obstacles.tolist(), ground.obstacle_kinds, strict=True):
        circle(x, y, radius, GRASS if kind == "grass" else ROCK, kind)
    for mine in ground.mines:
        circle(mine.x, mine.y, MINE_MARK_M, MINE, "mine: depth, contrast at the surface")
        _label(axes, mine)


def _label(axes: Axes, mine: Mine) -> None:
    """Above the mine's mark: narrower than mines lie apart, so that labels do not meet."""
    where = "surface" if mine.kind == "surface" else f"{mine.depth * 100:g} cm"
    axes.text(
        mine.x,
        mine.y + MINE_MARK_M + LABEL_GAP_M,
        f"{mine.id}: {where}\n{mine.contrast_k:+.1f} K",
        color="white",
        fontsize=7,
        horizontalalignment="center",
        verticalalignment="bottom",
        path_effects=[withStroke(linewidth=2, foreground="black")],
    )
