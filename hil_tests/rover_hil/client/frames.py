"""Pictures that a lock-stepped rig hands over, until they are taken."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.errors import BadInput


class RigFrames:
    """The frames that a lock-stepped rig hands over: what it delivered waits here until it is taken.

    `accept` takes one reply's headers and the pixels behind it; iterating empties the queue. Frames missing from
    the sequence are counted in `lost`. A picture that repeats counts as one with a closed shutter: it shows nothing.
    """

    def __init__(self) -> None:
        self._waiting: deque[Frame] = deque()
        self._next_sequence: int | None = None
        self._frozen = FrozenPicture()
        self.lost = 0

    def accept(self, headers: Sequence[Mapping[str, Any]], pixels: bytes) -> None:
        """Queues the frames described by `headers` (sequence, exposure_us, ffc, width, height).

        pixels: their counts, little-endian uint16, one frame after the other.
        Raises BadInput when the number of bytes does not agree with the headers; nothing is queued then.
        """
        expected = sum(2 * int(h["width"]) * int(h["height"]) for h in headers)
        if len(pixels) != expected:
            raise BadInput(f"rig frames: {len(pixels)} bytes of pixels, their headers say {expected}")
        offset = 0
        for header in headers:
            width, height = int(header["width"]), int(header["height"])
            counts = np.frombuffer(pixels, dtype="<u2", count=width * height, offset=offset)
            offset += 2 * width * height
            sequence = int(header["sequence"])
            if self._next_sequence is not None:
                self.lost += max(0, sequence - self._next_sequence)
            self._next_sequence = sequence + 1
            picture = counts.reshape(height, width).astype(np.uint16)
            repeated = self._frozen.repeats(picture)
            closed = bool(header["ffc"]) or repeated
            self._waiting.append(Frame(picture, int(header["exposure_us"]) * 1e-6, sequence, closed))

    def __len__(self) -> int:
        return len(self._waiting)

    def __iter__(self) -> Iterator[Frame]:
        while self._waiting:
            yield self._waiting.popleft()
