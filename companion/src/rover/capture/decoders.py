"""OpenCV's picture decoders without what they and libpng, libjpeg and libtiff print: one line of ours is enough."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


def decode_quietly(content: bytes) -> NDArray[Any] | None:
    """The first picture in `content` with its depth and channels kept; None where there is none to be read."""
    if not content:
        return None
    with silence():
        try:
            return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error:
            return None


@contextmanager
def silence() -> Iterator[None]:
    """Sends what the libraries write to the process's stderr nowhere; they know no other way to be told."""
    level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
        cv2.utils.logging.setLogLevel(level)
