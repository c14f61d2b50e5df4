"""Thermal cameras on V4L2 that deliver Y16: Lepton on a PureThermal, Boson, and others that look like them.

OpenCV hands over what the driver delivers when it is told the format ('Y16 ') and told to convert nothing. Whether it
did is asserted on the first picture: a picture of 8 bits, or one turned into colour, ends the source with one line.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import register
from rover.capture.telemetry import Telemetry, split_telemetry
from rover.errors import BadInput, RoverError

Y16 = cv2.VideoWriter.fourcc(*"Y16 ")
# Seconds before the first attempt to reopen a camera; each further one waits twice as long, up to the bound.
FIRST_DELAY, MAX_DELAY = 0.1, 5.0

# Seconds without a camera after which the source ends with CameraLost.
GIVE_UP_AFTER = 60.0

# A driver's time stamp further from now than this is on another clock, and not used.
MAX_STAMP_AGE = 1.0


class CameraLost(RoverError):
    """The camera went away and did not come back."""


class Capture(Protocol):
    """What is used of cv2.VideoCapture."""

    def isOpened(self) -> bool: ...  # noqa: N802
    def set(self, prop: int, value: float) -> bool: ...
    def get(self, prop: int) -> float: ...
    def read(self) -> tuple[bool, Any]: ...
    def release(self) -> None: ...


@register("v4l2")
class V4l2Source:
    """`v4l2:/dev/video0[?size=160x120][&unit=centikelvin|raw]`; `v4l2:0` is /dev/video0.

    Without `unit` the telemetry says what counts mean; without telemetry they are kelvin × 100. With AGC on they mean
    nothing, whatever `unit` says. `size` asks the
    driver for that picture, telemetry rows included. Iterating reads until the camera is lost for GIVE_UP_AFTER.
    Raises BadInput when it is not there at the start or does not deliver 16 bits, CameraLost when it went away.
    """

    live = True

    def __init__(
        self,
        location: str,
        opener: Callable[[str], Capture] | None = None,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        parsed = Location.parse(location, ("size", "unit"))
        self.device = f"/dev/video{parsed.place}" if parsed.place.isdigit() else parsed.place
        self._size = parsed.size()
        self._unit = parsed.unit("centikelvin")
        self._unit_given = "unit" in parsed.options
        self._opener = opener or _open_device
        self._clock, self._sleep = clock, sleep
        self.reconnects = 0
        self.lost = 0

    def __iter__(self) -> Iterator[Frame]:
        capture = self._open()
        if capture is None:
            raise BadInput(f"{self.device}: no camera can be opened there; `rover doctor` lists those that are seen")
        frozen = FrozenPicture()
        shape: tuple[int, ...] | None = None
        sequence, counter = -1, None
        try:
            while True:
                good, delivered = capture.read()
                if not good or delivered is None:
                    capture.release()
                    capture = self._reopen()
                    counter = None
                    continue
                counts = as_counts(delivered, self.device)
                if shape is not None and counts.shape != shape:
                    raise BadInput(f"{self.device}: the picture changed from {_size(shape)} to {_size(counts.shape)}")
                shape = counts.shape
                picture, telemetry = split_telemetry(counts)
                missed = _missed(counter, telemetry)
                self.lost += missed
                sequence += 1 + missed
                counter = telemetry.frame_counter if telemetry else None
                frame = Frame(picture, self._exposed(capture), sequence, frozen.repeats(picture),
                              kelvin_per_count=self._unit, camera=f"v4l2 {self.device}")  # fmt: skip
                yield self._with(telemetry, frame) if telemetry else frame
        finally:
            if capture is not None:
                capture.release()

    def _with(self, telemetry: Telemetry, frame: Frame) -> Frame:
        unit = self._unit if self._unit_given else telemetry.kelvin_per_count
        return replace(
            frame,
            ffc=frame.ffc or telemetry.ffc_state == "running",
            since_ffc=telemetry.since_ffc if telemetry.ffc_state != "never" else None,
            kelvin_per_count=None if telemetry.agc else unit,
            doubt="grey levels, no temperatures: its telemetry says that AGC is on" if telemetry.agc else None,
        )

    def _exposed(self, capture: Capture) -> float:
        """The driver's time stamp where it is on the clock of the companion, else now."""
        now = self._clock()
        stamp = capture.get(cv2.CAP_PROP_POS_MSEC) * 1e-3
        return stamp if 0.0 <= now - stamp < MAX_STAMP_AGE else now

    def _open(self) -> Capture | None:
        capture = self._opener(self.device)
        if not capture.isOpened():
            capture.release()
            return None
        capture.set(cv2.CAP_PROP_FOURCC, Y16)
        capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
        if self._size is not None:
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, self._size[0])
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, self._size[1])
        return capture

    def _reopen(self) -> Capture:
        gone_at, delay = self._clock(), FIRST_DELAY
        while self._clock() - gone_at < GIVE_UP_AFTER:
            self._sleep(delay)
            delay = min(2.0 * delay, MAX_DELAY)
            capture = self._open()
            if capture is not None:
                self.reconnects += 1
                return capture
        raise CameraLost(f"{self.device}: the camera went away and did not come back within {GIVE_UP_AFTER:.0f} s")


def as_counts(delivered: NDArray[Any], name: str) -> NDArray[np.uint16]:
    """What OpenCV handed over as (H, W) uint16; some of its versions give the two bytes of a pixel as two channels.

    Raises BadInput, with what came instead and what to do.
    """
    if delivered.dtype == np.uint16 and delivered.ndim == 3 and delivered.shape[2] == 1:
        delivered = delivered[:, :, 0]
    elif delivered.dtype == np.uint8 and delivered.ndim == 3 and delivered.shape[2] == 2:
        delivered = np.ascontiguousarray(delivered).view("<u2")[:, :, 0]
    if delivered.dtype != np.uint16 or delivered.ndim != 2 or min(delivered.shape) < 8:
        raise BadInput(
            f"{name}: delivers {delivered.dtype} of shape {delivered.shape}, 16 bits of one channel (Y16) expected; "
            "is it the thermal camera's node, and is its raw output switched on?"
        )
    return np.array(delivered, dtype=np.uint16)  # a copy: the driver's buffer is used again


def _missed(counter: int | None, telemetry: Telemetry | None) -> int:
    # The Lepton counts at 26 Hz and sends every third frame as new: only a gap beyond that is a loss.
    if counter is None or telemetry is None:
        return 0
    step = telemetry.frame_counter - counter
    return max(0, round(step / 3) - 1) if 0 < step < 3000 else 0


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}×{shape[0]}"


def _open_device(device: str) -> Capture:
    return cv2.VideoCapture(device, cv2.CAP_V4L2)
