"""Processor time of detection, with kelvin and metres and without: `python -m tools.evaluate.timing`.

One core, medians; the first time a process does it is told beside. Pictures are textured soil, so that as many
candidates as there may be are looked at.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.detection.classifier import GROUND, PICTURES, Classifier, default_model
from rover.detection.ground.detect import DetectSettings, detect
from rover.detection.ground.image import GroundImage, GroundRectifier, from_picture
from rover.detection.picture.detect import detect_in_picture, prepare
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

from tools.evaluate.figures import table

ROUNDS = 31
PATCHES = 64


def soil(width: int, height: int) -> NDArray[np.uint16]:
    """A picture of textured ground, kelvin × 100."""
    noise = np.random.default_rng(0).standard_normal((height, width)).astype(np.float32)
    kelvin = 300.0 + sum(0.3 * size * cv2.GaussianBlur(noise, (0, 0), size) for size in (1.0, 3.0, 8.0))
    return np.round(100.0 * kelvin).astype(np.uint16)


def twice_as_fine(camera: CameraModel) -> CameraModel:
    """The same view with twice the pixels along both axes."""
    return replace(
        camera,
        width=2 * camera.width,
        height=2 * camera.height,
        fx=2 * camera.fx,
        fy=2 * camera.fy,
        cx=2 * camera.cx + 0.5,
        cy=2 * camera.cy + 0.5,
    )


def row(title: str, work: Callable[[], object]) -> list[str]:
    """Title, median and first processor time, milliseconds."""
    times = []
    for _ in range(ROUNDS):
        begun = time.thread_time()
        work()
        times.append(1e3 * (time.thread_time() - begun))
    return [title, f"{median(times):.1f}", f"{times[0]:.1f}"]


def report() -> str:
    """Markdown."""
    cv2.setNumThreads(1)
    classifier, camera = Classifier(default_model(GROUND), GROUND), load_camera("lepton-160")

    def found(image: GroundImage) -> object:
        return detect(image, classifier, DetectSettings())

    picture = soil(320, 240).astype(np.float32) / np.float32(100.0)

    def laid(scale: float) -> object:
        return found(from_picture(picture, scale))

    rows = [
        row(f"320x240 from above, {100 * scale:g} cm a pixel", partial(laid, scale)) for scale in (0.005, 0.01, 0.02)
    ]

    def rectified(rectifier: GroundRectifier, frame: Frame) -> object:
        return found(rectifier.rectify(frame))

    for model in (twice_as_fine(camera), camera):
        rectifier, frame = GroundRectifier(model), Frame(soil(model.width, model.height), 0.0, 0)
        title = f"{model.width}x{model.height} of a mounted camera, as in a mission"
        rows.append(row(title, partial(rectified, rectifier, frame)))
    vectors = np.zeros((PATCHES, classifier.length), np.float32)
    rows.append(row(f"the network alone, {PATCHES} candidates", lambda: classifier.predict(vectors)))
    without = Classifier(default_model(PICTURES), PICTURES)
    prepare(without)
    for width, height in ((640, 640), (320, 240)):
        kelvin = soil(width, height).astype(np.float32)
        grey = np.clip(128.0 + (kelvin - kelvin.mean()) * (40.0 / kelvin.std()), 0.0, 255.0).astype(np.float32)
        rows.append(row(f"{width}x{height} without kelvin or scale", partial(detect_in_picture, grey, without)))
    return table(["", "ms", "the first time"], rows)


if __name__ == "__main__":
    print(report())
