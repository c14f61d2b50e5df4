"""The plot in docs/reference/vision.md: a frame, the same on the ground with its matches, three estimates of a drive.

All of it is synthetic.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from rover.capture.frame import Frame
from rover.capture.radiometry import ZERO_CELSIUS
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera
from rover.vision.localization.ground_view import GroundView
from rover.vision.localization.keyframes import Keyframe
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.observation import Observer
from rover.vision.localization.placement import PlacementSettings, place
from rover.vision.localization.settings import LocalizerSettings
from rover.vision.registration.matching import hamming, mutual_matches
from rover.vision.registration.preprocess import Preprocessor

from tools.bench.vision.drives import FRAME_STEPS, START_SIGMA, Scene, random_drive, scenes
from tools.bench.vision.way import STEP_M, Drive

# The frame that is shown, and the one before it that it is matched with, in steps of the drive.
EARLIER, LATER = 40, 40 + 2 * FRAME_STEPS
MAX_INLIER_M = 0.03
LENGTH_M, SLIP = 8.0, 0.05
INLIER, OUTLIER = "limegreen", "red"
COLOURS = {"truth": "black", "wheels and frames": "limegreen", "frames alone": "deepskyblue", "wheels alone": "red"}


def figure(camera_name: str, seed: int) -> Figure:
    """Three panels side by side, of the drive over the field of that seed."""
    ((_, at),) = scenes(load_camera(camera_name), 1, seed)
    drive = random_drive(at, SLIP, LENGTH_M)
    earlier, later = (at.frame(drive.poses[step], step) for step in (EARLIER, LATER))
    made = Figure(figsize=(15.0, 4.8), layout="constrained")
    frame, ground, drives = made.subplots(1, 3, width_ratios=(1.25, 1.2, 0.9))
    _frame(made, frame, later)
    _matches(ground, at, earlier, later)
    _drives(drives, at, drive)
    made.suptitle(f"Localization on a synthetic drive ({camera_name}, field {seed})")
    return made


def _frame(made: Figure, axes: Axes, frame: Frame) -> None:
    shown = axes.imshow(frame.kelvin() - np.float32(ZERO_CELSIUS), cmap="inferno")
    made.colorbar(shown, ax=axes, label="temperature, °C", shrink=0.7)
    axes.set(title="One frame", xlabel="u, px", ylabel="v, px")


def _matches(axes: Axes, at: Scene, earlier: Frame, later: Frame) -> None:
    """The later frame on the ground; lines lead to where the earlier one saw the same feature."""
    settings, view = LocalizerSettings(), GroundView(at.camera)
    observer = Observer(at.camera, settings.preprocess, settings.features, settings.keyframe_features)
    before, seen = observer.look(earlier), observer.look(later)
    known = Keyframe(before.ground, before.descriptors, before.pixel_m, earlier.time)
    rows, columns = mutual_matches(hamming(seen.descriptors, known.descriptors), None, settings.placement.match)
    found = place(seen, known, at.camera, None, PlacementSettings()).found
    fits = np.zeros(len(rows), dtype=bool)
    if found is not None:
        off = found.pose.transform(seen.ground[rows]) - known.ground[columns]
        fits = np.hypot(off[:, 0], off[:, 1]) < MAX_INLIER_M
    chain = Preprocessor(settings.preprocess)
    laid = np.ma.masked_where(view.mask == 0, chain.to_8_bit(view.look(chain.clean(later.counts))))
    x_min, x_max, y_min, y_max = view.bounds
    # Ahead is up, left is left: y of base_link falls to the right.
    axes.imshow(laid, cmap="gray", extent=(y_max, y_min, x_min, x_max))
    here, there = seen.ground[rows][:, ::-1], known.ground[columns][:, ::-1]
    for name, colour, some in (("fits", INLIER, fits), ("does not fit", OUTLIER, ~fits)):
        lines = list(np.stack((here[some], there[some]), axis=1))
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=1))
        axes.plot(*here[some].T, "o", markerfacecolor="none", markersize=4, color=colour,
                  label=f"{name}: {int(some.sum())} matches")  # fmt: skip
    axes.set(title="On the ground, matched with a frame before", xlabel="y, m (to the left)", ylabel="x, m (ahead)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False)


def _drives(axes: Axes, at: Scene, drive: Drive) -> None:
    """Truth and the three estimates over the area."""
    fused = Localizer(at.camera, drive.poses[0], START_SIGMA)
    alone = Localizer(at.camera, drive.poses[0], START_SIGMA, LocalizerSettings(motion="frames"))
    estimates: dict[str, list[Pose2]] = {name: [] for name in COLOURS}
    for step in range(1, len(drive.poses)):
        fused.predict(step * STEP_M, drive.left[step - 1], drive.right[step - 1])
        if step % FRAME_STEPS == 0:
            frame = at.frame(drive.poses[step], step)
            fused.observe(frame)
            alone.observe(frame)
            now = (drive.poses[step], fused.pose, alone.pose, fused.odometry_only)
            for name, pose in zip(COLOURS, now, strict=True):
                estimates[name].append(pose)
    for name, poses in estimates.items():
        axes.plot([p.x for p in poses], [p.y for p in poses], color=COLOURS[name], label=name,
                  linewidth=2.5 if name == "truth" else 1.2, linestyle="-" if name == "truth" else "--")  # fmt: skip
    width, length = at.field.ground.area
    axes.set(title=f"{LENGTH_M:g} m of driving, {SLIP:.0%} slip", xlabel="x, m", ylabel="y, m")
    axes.set(xlim=(0.0, width), ylim=(0.0, length), aspect="equal")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
