"""Frames from a video file: 8 bits (grey levels, no temperatures), or 16 bits where the file has them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.decoders import silence
from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import FRAME_PERIOD, register
from rover.capture.v4l2 import CameraLost
from rover.errors import BadInput

# A network camera is given up after so long.
OPEN_S = 10.0


@register("video")
class VideoSource:
    """`video:FILE[?fps=9][&unit=raw|centikelvin]`: what OpenCV can open; colour becomes grey.

    Times follow the file's rate unless `fps` is given. Raises BadInput when it cannot be opened or has no frames.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("fps", "unit"))
        self.file = Path(parsed.place)
        self._period = 1.0 / parsed.number("fps", 1.0) if "fps" in parsed.options else None
        self._unit = parsed.unit("raw")
        if not self.file.is_file():
            raise BadInput(f"{self.file}: no such video")

    def __iter__(self) -> Iterator[Frame]:
        with silence():
            capture = cv2.VideoCapture(str(self.file))
        try:
            if not capture.isOpened():
                raise BadInput(f"{self.file}: cannot be opened as a video")
            capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)  # otherwise 16 bits come as 8
            rate = capture.get(cv2.CAP_PROP_FPS)
            period = self._period or (1.0 / rate if 0.0 < rate < 1000.0 else FRAME_PERIOD)
            frozen = FrozenPicture()
            sequence = 0
            while True:
                with silence():
                    good, delivered = capture.read()
                if not good:
                    break
                counts = _grey(delivered, capture, str(self.file))
                yield Frame(counts, sequence * period, sequence, frozen.repeats(counts), kelvin_per_count=self._unit)
                sequence += 1
            if sequence == 0:
                raise BadInput(f"{self.file}: no frame of this video can be decoded")
        finally:
            capture.release()


@register("rtsp")
class RtspSource:
    """`rtsp://HOST/PATH`: a network camera, by OpenCV's FFmpeg; colour becomes grey. Grey levels, no temperatures.

    Raises BadInput when it cannot be opened within OPEN_S, CameraLost when no picture comes for as long.
    """

    live = True

    def __init__(self, location: str) -> None:
        self.address = f"rtsp:{location}"

    def __iter__(self) -> Iterator[Frame]:
        wait = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(OPEN_S * 1e3), cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(OPEN_S * 1e3)]
        with silence():
            capture = cv2.VideoCapture(self.address, cv2.CAP_FFMPEG, wait)
        try:
            if not capture.isOpened():
                raise BadInput(f"{self.address}: no camera answers there within {OPEN_S:g} s")
            frozen = FrozenPicture()
            sequence = 0
            while True:
                with silence():
                    good, delivered = capture.read()
                if not good:
                    raise CameraLost(f"{self.address}: the camera sends no pictures any more")
                counts = _grey(delivered, capture, self.address)
                yield Frame(counts, time.monotonic(), sequence, frozen.repeats(counts), kelvin_per_count=None,
                            camera=self.address)  # fmt: skip
                sequence += 1
        finally:
            capture.release()


def _grey(delivered: NDArray[Any], capture: cv2.VideoCapture, name: str) -> NDArray[np.uint16]:
    height = int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
    if delivered.ndim == 3 and delivered.shape[2] == 3:
        delivered = cv2.cvtColor(delivered, cv2.COLOR_BGR2GRAY)
    elif delivered.ndim == 3 and delivered.shape[2] == 1:
        delivered = delivered[:, :, 0]
    if delivered.ndim != 2 or delivered.dtype not in (np.uint8, np.uint16):
        raise BadInput(f"{name}: {delivered.dtype} of shape {delivered.shape}; one channel of 8 or 16 bits expected")
    return delivered[:height].astype(np.uint16)  # a planar picture has its colours below the grey
