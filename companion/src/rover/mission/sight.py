"""Whether the camera still shows anything: what comes of a camera that has died, repeats itself, or stays shut."""

from __future__ import annotations

from collections.abc import Sequence

from rover.capture.frame import Frame

# Seconds without a picture that shows ground after which the rover brakes; a shutter is closed for 1 to 2 s.
BLIND_AFTER = 3.0

# Seconds without any picture after which the mission ends: a camera that was unplugged may come back before.
LOST_AFTER = 10.0

# Seconds of pictures that show nothing, repeated or taken behind the shutter, after which the mission ends.
SHUT_AFTER = 30.0


class Sight:
    """Times of the last pictures, seconds of the companion's clock."""

    def __init__(self) -> None:
        self._any: float | None = None
        self._good: float | None = None
        self._doubt: str | None = None

    def take(self, now: float, frames: Sequence[Frame]) -> None:
        """One cycle; the first begins the waiting for the first picture."""
        if self._any is None or frames:
            self._any = now
        if self._good is None or any(not frame.ffc for frame in frames):
            self._good = now
        if frames:
            self._doubt = frames[-1].doubt

    def blind(self, now: float) -> bool:
        """True when nothing has been seen for so long that the rover should stand."""
        return self._good is not None and now - self._good > BLIND_AFTER

    def lost(self, now: float) -> str | None:
        """Why the mission cannot go on, as one sentence; None while it can."""
        if self._any is not None and now - self._any > LOST_AFTER:
            return f"the camera is lost: no picture for {LOST_AFTER:g} s"
        if self._good is not None and now - self._good > SHUT_AFTER:
            if self._doubt is not None:
                return f"the camera has shown no temperatures of ground for {SHUT_AFTER:g} s: {self._doubt}"
            return f"the camera shows nothing: its picture has stood still for {SHUT_AFTER:g} s"
        return None
