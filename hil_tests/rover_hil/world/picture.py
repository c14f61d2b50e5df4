"""A picture of one effect: the same short drive in a friendly world and with the effect alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rover.capture.radiometry import ZERO_CELSIUS
from rover.mission.config import Mission, load
from rover.vision.camera.file import load_camera
from rover_plant import Plant

from rover_hil.figure_file import write_figure
from rover_hil.ground import Ground, build
from rover_hil.plant_config import build_plant
from rover_hil.world.file import FRIENDLY, World

# The drive: ahead, then a turn on the spot to the left, in which the last picture is taken; seconds and duties.
DRIVE = ((6.0, 0.5, 0.5), (3.0, -0.4, 0.4))
STEP_S = 0.05


@dataclass(frozen=True, eq=False)
class Drive:
    """What came of it. pictures: (exposure s, delivery s, pixels in kelvin); rows: time, x, y, battery V, ranges m."""

    ground: Ground
    pictures: list[tuple[float, float, NDArray[np.float64]]]
    rows: NDArray[np.float64]


def draw(world: World, effect: str, mission: str, seed: int, path: Path) -> None:
    """Writes the picture (PNG or SVG). Raises BadInput."""
    write_figure(figure(effect, drive(load(mission), FRIENDLY, seed), drive(load(mission), world, seed)), path)


def drive(mission: Mission, world: World, seed: int) -> Drive:
    """The short drive of a rover without firmware in that world."""
    camera = load_camera(mission.rover.camera)
    with TemporaryDirectory(prefix="rover-world-") as folder:
        file = Path(folder) / "world.toml"
        file.write_text(world.text(), encoding="utf-8")
        mission = replace(mission, field=replace(mission.field, world=str(file)))
        ground = build(mission, seed)
        plant = build_plant(mission, ground, camera, seed)
    rows, pictures = [], []
    for lasts, left, right in DRIVE:
        for _ in range(round(lasts / STEP_S)):
            for _ in range(round(STEP_S * 1e3)):
                plant.step(left, right, True)
            rows.append(_row(plant))
            for _, exposed, delivered, ffc, pixels in plant.take_frames():
                kelvin = np.frombuffer(pixels, "<u2").reshape(camera.height, camera.width) * 0.01
                if not ffc:
                    pictures.append((exposed * 1e-6, delivered * 1e-6, kelvin))
    return Drive(ground, pictures, np.array(rows))


def _row(plant: Plant) -> list[float]:
    x, y, heading = plant.pose()
    ranges = [plant.sonar_range(sensor, x, y, heading) for sensor in range(3)]
    return [plant.now_us * 1e-6, x, y, plant.battery()[0], *(np.nan if far is None else far for far in ranges)]


def figure(effect: str, friendly: Drive, changed: Drive) -> Figure:
    """The last pictures of both, the ground with the effect, the way, and what pictures, sonar and battery tell."""
    made = Figure(figsize=(16.0, 7.5), layout="constrained")
    made.suptitle(f"{effect} (simulated)")
    axes = made.subplots(2, 4)
    last, other = friendly.pictures[-1][2], changed.pictures[-1][2]
    low, high = np.percentile(np.concatenate((last, other)), (1, 99.5)) - ZERO_CELSIUS
    for panel, picture, title in ((axes[0, 0], last, "friendly"), (axes[0, 1], other, f"with {effect}")):
        shown = panel.imshow(picture - ZERO_CELSIUS, cmap="inferno", vmin=low, vmax=high)
        panel.set_title(f"last picture, in a turn: {title}", fontsize=9)
        panel.set_axis_off()
    made.colorbar(shown, ax=axes[0, :2], label="°C", shrink=0.8)
    _ground(axes[0, 2], changed.ground)
    both = ((friendly, "friendly"), (changed, effect))
    for panel, column, label in ((axes[1, 0], 3, "battery, V"), (axes[1, 1], 5, "range of the centre sonar, m")):
        for made_drive, name in both:
            panel.plot(made_drive.rows[:, 0], made_drive.rows[:, column], label=name)
        panel.set_ylabel(label)
    for made_drive, name in both:
        axes[1, 2].plot(made_drive.rows[:, 1], made_drive.rows[:, 2], label=name)
        stamps = np.array([stamp for stamp, _, _ in made_drive.pictures])
        delays = [1e3 * (delivered - stamp) for stamp, delivered, _ in made_drive.pictures]
        axes[1, 3].plot(stamps, delays, ".-", label=name)
        axes[0, 3].plot(stamps, [float(kelvin.mean()) - ZERO_CELSIUS for _, _, kelvin in made_drive.pictures])
    axes[1, 2].set_ylabel("way: y over x, m")
    axes[1, 3].set_ylabel("from stamp to delivery, ms")
    axes[1, 3].set_ylim(bottom=min(0.0, axes[1, 3].get_ylim()[0]), top=max(100.0, axes[1, 3].get_ylim()[1]))
    axes[0, 3].set_ylabel("mean of the picture, °C")
    axes[1, 2].legend(fontsize=8)
    return made


def _ground(axes: Axes, ground: Ground) -> None:
    celsius = ground.temperature[::2, ::2] - np.float32(ZERO_CELSIUS)
    low, high = np.percentile(celsius, (2.0, 99.5))
    width, height = ground.grid.columns * ground.resolution, ground.grid.rows * ground.resolution
    extent = (ground.origin_x, ground.origin_x + width, ground.origin_y, ground.origin_y + height)
    axes.imshow(celsius, cmap="inferno", origin="lower", vmin=low, vmax=high, extent=extent)
    axes.set_title("ground with it", fontsize=9)
