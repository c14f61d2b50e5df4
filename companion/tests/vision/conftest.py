"""Fixes OpenCV to one thread as a mission does, and finds the real pictures."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import pytest

cv2.setNumThreads(1)


@pytest.fixture(scope="session")
def rover_data() -> Path:
    """The folder of real data, or a skip that says how to get it."""
    folder = os.environ.get("ROVER_DATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip("ROVER_DATA is not set to the folder of real pictures")
    return Path(folder)
