"""The plot in docs/reference/vision.md: a frame, its matches on the ground, and three estimates of one drive."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera
from rover.vision.localization.ground_view import GroundView
from rover.vision.localization.localizer import Localizer, LocalizerSettings
from rover.vision.localization.observation import Observer
from rover.vision.localization.placement import PlacementSettings, place
from rover.vision.registration.matching import hamming, mutual_matches
from rover.vision.registration.preprocess import Preprocessor

from tools.bench.vision.drives import FRAME_STEPS, START_SIGMA, Scene, scenes, twenty_metres
from tools.bench.vision.way import STEP, Drive

HEIGHT = 480
INLIER, OUTLIER = (120, 220, 60), (60, 60, 230)
COLOURS = {"truth": (255, 255, 255), "wheels and frames": (120, 220, 60), "frames alone": (230, 180, 60),
           "wheels alone": (60, 60, 230)}  # fmt: skip


def draw(path: Path, camera_name: str, seed: int) -> None:
    """Writes the picture; synthetic all through."""
    ((_, at),) = scenes(load_camera(camera_name), 1, seed)
    drive = twenty_metres(at, 0.05, 8.0)
    first, second = 40, 40 + 2 * FRAME_STEPS
    frames = [at.frame(drive.poses[step], step) for step in (first, second)]
    panels = [_frame(frames[1]), _matches(at, frames[0], frames[1]), _ways(at, drive)]
    cv2.imwrite(str(path), np.hstack([_scaled(panel) for panel in panels]))


def _scaled(panel: NDArray[np.uint8]) -> NDArray[np.uint8]:
    factor = HEIGHT / panel.shape[0]
    return np.asarray(cv2.resize(panel, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8)


def _frame(frame: Frame) -> NDArray[np.uint8]:
    grey = cv2.normalize(frame.counts, None, 0, 255, cv2.NORM_MINMAX, cv2.CV_8U)
    return np.asarray(cv2.applyColorMap(cv2.resize(grey, None, fx=4, fy=4), cv2.COLORMAP_INFERNO), np.uint8)


def _matches(at: Scene, earlier: Frame, later: Frame) -> NDArray[np.uint8]:
    """The later frame on the ground; lines lead to where the earlier one saw the same feature."""
    settings, view = LocalizerSettings(), GroundView(at.camera)
    observer = Observer(at.camera, settings.preprocess, settings.features, settings.keyframe_features)
    known, seen = observer.look(earlier), observer.look(later)
    rows, columns = mutual_matches(hamming(seen.descriptors, known.descriptors), None, settings.placement.match)
    found = place(seen, known, at.camera, None, PlacementSettings()).found
    chain = Preprocessor(settings.preprocess)
    laid = chain.to_8_bit(view.look(chain.clean(later.counts)))
    laid[view.mask == 0] = 0
    shown = cv2.cvtColor(cv2.resize(laid, None, fx=4, fy=4), cv2.COLOR_GRAY2BGR)
    here, there = view.from_base(seen.ground[rows]) * 4.0 + 2.0, view.from_base(known.ground[columns]) * 4.0 + 2.0
    fits = np.zeros(len(rows), dtype=bool)
    if found is not None:
        off = found.pose.transform(seen.ground[rows]) - known.ground[columns]
        fits = np.hypot(off[:, 0], off[:, 1]) < 0.03
    for a, b, fit in zip(here.tolist(), there.tolist(), fits.tolist(), strict=True):
        ends = [tuple(round(v) for v in p) for p in (a, b)]
        cv2.line(shown, ends[0], ends[1], INLIER if fit else OUTLIER, 1, cv2.LINE_AA)
        cv2.circle(shown, ends[0], 3, INLIER if fit else OUTLIER, 1, cv2.LINE_AA)
    return np.asarray(shown, np.uint8)


def _ways(at: Scene, drive: Drive) -> NDArray[np.uint8]:
    """Truth and the three estimates over the area."""
    fused = Localizer(at.camera, drive.poses[0], START_SIGMA)
    alone = Localizer(at.camera, drive.poses[0], START_SIGMA, LocalizerSettings(motion="frames"))
    ways: dict[str, list[Pose2]] = {name: [] for name in COLOURS}
    for step in range(1, len(drive.poses)):
        fused.predict(step * STEP, drive.left[step - 1], drive.right[step - 1])
        if step % FRAME_STEPS == 0:
            frame = at.frame(drive.poses[step], step)
            fused.observe(frame)
            alone.observe(frame)
            poses = (drive.poses[step], fused.pose, alone.pose, fused.odometry_only)
            for name, pose in zip(COLOURS, poses, strict=True):
                ways[name].append(pose)
    width, length = at.field.ground.area
    metre = HEIGHT * 2 / length
    canvas = np.full((HEIGHT * 2, round(width * metre), 3), 40, np.uint8)
    for row, name in enumerate(reversed(COLOURS)):
        line = np.array([(pose.x * metre, (length - pose.y) * metre) for pose in ways[name]]).round().astype(np.int32)
        cv2.polylines(canvas, [line], False, COLOURS[name], 3 if name == "truth" else 2, cv2.LINE_AA)
        cv2.putText(canvas, name, (14, 34 + 30 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.8, COLOURS[name], 2, cv2.LINE_AA)
    return canvas
