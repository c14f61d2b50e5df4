"""A rig's virtual time by the clock on the wall."""

from __future__ import annotations

import time

import numpy as np
from rover.capture.frame import Frame
from rover.capture.publisher import FramePublisher

from rover_hil.rig import Rig, RigFrame

# A rig that is slower than real time is not made to catch up: it loses what lies beyond this.
MAX_STEP_US = 100_000


class RealTime:
    """Lets a rig run abreast of real time. `paused`: its time stands still."""

    def __init__(self, rig: Rig, publisher: FramePublisher | None = None, paused: bool = False) -> None:
        """`publisher` takes the camera's pictures."""
        self._rig = rig
        self._publisher = publisher
        self.paused = paused
        self._offset = self._present_offset()

    def step(self) -> None:
        """Brings the rig up to the present; to be called often. Raises RigFailed."""
        frames: tuple[RigFrame, ...] = ()
        if self.paused:
            self._offset = self._present_offset()
        else:
            wanted_us = round((time.monotonic() - self._offset) * 1e6)
            to_us = min(wanted_us, self._rig.now_us + MAX_STEP_US)
            self._offset += (wanted_us - to_us) * 1e-6
            frames = self._rig.advance_free(to_us)
        if self._publisher is not None:
            self._publisher.publish(*map(self._picture, frames))

    def _present_offset(self) -> float:
        """Seconds from the rig's time to the system's monotonic clock."""
        return time.monotonic() - self._rig.now_us * 1e-6

    def _picture(self, frame: RigFrame) -> Frame:
        """As its camera would give it."""
        size = self._rig.camera["height"], self._rig.camera["width"]
        counts = np.frombuffer(frame.counts, "<u2").reshape(size).astype(np.uint16)
        return Frame(counts, frame.exposure_us * 1e-6 + self._offset, frame.sequence, frame.ffc)
