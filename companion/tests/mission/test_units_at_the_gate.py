"""A camera with the wrong settings, from the driver's buffer to the gate: pre-flight fails and says which settings."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.cptv import CptvSource
from rover.capture.v4l2 import V4l2Source
from rover.link.self_test import Finding
from rover.mission.preflight import judge_pictures
from rover.vision.camera.file import load_camera

Counts = NDArray[np.uint16]

CAMERA = load_camera("lepton-160")
PERIOD = 1.0 / 8.7
COUNT = 5
AGC_BIT = 1 << 12


class Driver:
    """Delivers pictures at the rate of a Lepton, with the interface of cv2.VideoCapture that the source uses."""

    def __init__(self, pictures: list[Counts]) -> None:
        self.pictures, self.now = list(pictures), 100.0

    def isOpened(self) -> bool:  # noqa: N802
        return True

    def set(self, prop: int, value: float) -> bool:
        return True

    def get(self, prop: int) -> float:
        return 0.0

    def read(self) -> tuple[bool, Any]:
        self.now += PERIOD
        return True, self.pictures.pop(0)

    def release(self) -> None:
        pass


def at_the_gate(pictures: list[Counts], location: str = "/dev/video0") -> Finding:
    driver = Driver(pictures)
    frames = list(islice(V4l2Source(location, lambda _: driver, lambda: driver.now), len(pictures)))
    return judge_pictures(frames, [0.08] * len(frames), CAMERA)


def with_telemetry(pictures: list[Counts], agc: bool = False, linear: bool = True) -> list[Counts]:
    """With the rows that a Lepton sends below its picture; TLinear at 0.01 K where it is `linear`."""
    whole = []
    for number, picture in enumerate(pictures):
        words = np.zeros(320, np.uint16)
        words[0], words[24] = 0x0E0E, 30515
        words[1], words[2] = np.divmod(90_000 + 115 * number, 1 << 16)[::-1]
        words[3] = 3 << 4 | (AGC_BIT if agc else 0)
        words[20], words[30] = 300 + number, 60_000
        words[208], words[209] = linear, linear
        whole.append(np.vstack([picture, words.reshape(2, 160)]))
    return whole


def ground(seed: int, contrast_k: float = 5.0) -> list[Counts]:
    """Synthetic ground that drifts by, kelvin × 100."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:120, 0:160]
    turns = rng.uniform(0.01, 0.2, (5, 2))
    kelvin = [295.0 + contrast_k / 5.0 * sum(np.sin(a * (x + 3 * n) + b * y) for a, b in turns) for n in range(COUNT)]
    return [np.asarray(np.round(100.0 * (k + rng.normal(0.0, 0.05, k.shape))), np.uint16) for k in kelvin]


def real() -> list[Counts]:
    """A recording of raw counts, read at 0.03 K each: kelvin × 100."""
    data = os.environ.get("ROVER_DATA")
    if not data or not (Path(data) / "lepton" / "v2.cptv").is_file():
        pytest.skip("ROVER_DATA does not lead to lepton/v2.cptv: the recording is not part of the project")
    counts = [f.counts.astype(np.float64) for f in islice(CptvSource(str(Path(data) / "lepton" / "v2.cptv")), COUNT)]
    return [np.asarray(np.round(29300.0 + 3.0 * (c - np.median(counts[0]))), np.uint16) for c in counts]


def raw(kelvin_100: list[Counts]) -> list[Counts]:
    return [np.asarray(8000.0 + (k.astype(np.float64) - 29300.0) / 3.0, np.uint16) for k in kelvin_100]


def levels(kelvin_100: list[Counts], largest: int) -> list[Counts]:
    """Gain control: each picture is spread over all levels."""
    return [np.asarray((k - k.min()) / (int(k.max()) - int(k.min())) * largest, np.uint16) for k in kelvin_100]


def swapped(pictures: list[Counts]) -> list[Counts]:
    return [each.byteswap() for each in pictures]


WRONG: dict[str, tuple[Callable[[list[Counts]], list[Counts]], str]] = {
    "raw": (raw, "raw counts of 14 bits"),
    "raw, as the telemetry says": (lambda k: with_telemetry(raw(k), linear=False), "switch TLinear on"),
    "raw, though the telemetry says kelvin": (lambda k: with_telemetry(raw(k)), "raw counts of 14 bits"),
    "AGC in 8 bits": (lambda k: levels(k, 255), "switch AGC off"),
    "AGC in 16 bits": (lambda k: levels(k, 65535), "switch AGC off"),
    "AGC in 16 bits, with the bit": (lambda k: with_telemetry(levels(k, 65535), agc=True), "says that AGC is on"),
    "AGC in 16 bits, without the bit": (lambda k: with_telemetry(levels(k, 65535)), "switch AGC off"),
    "swapped": (swapped, "bytes of each pixel are swapped"),
    "swapped, raw": (lambda k: swapped(raw(k)), "bytes of each pixel are swapped"),
    "swapped, with telemetry": (lambda k: swapped(with_telemetry(k)), "bytes of each pixel are swapped"),
    "0.1 K": (lambda k: [np.asarray(np.round(each / 10.0), np.uint16) for each in k], "tenths of a kelvin"),
}
PICTURES = {"seed 0": lambda: ground(0), "seed 1, flat": lambda: ground(1, 2.0), "real": real}


@pytest.mark.parametrize("take", PICTURES.values(), ids=PICTURES.keys())
@pytest.mark.parametrize(("make", "name"), WRONG.values(), ids=WRONG.keys())
def test_what_a_camera_with_wrong_settings_delivers_fails_by_its_name(
    make: Callable[[list[Counts]], list[Counts]], name: str, take: Callable[[], list[Counts]]
) -> None:
    finding = at_the_gate(make(take()))
    assert not finding.ok
    assert finding.name == "camera"
    assert name in finding.detail
    assert "\n" not in finding.detail


@pytest.mark.parametrize("take", PICTURES.values(), ids=PICTURES.keys())
@pytest.mark.parametrize("make", [lambda k: k, with_telemetry], ids=["plain", "with telemetry"])
def test_kelvin_pass(make: Callable[[list[Counts]], list[Counts]], take: Callable[[], list[Counts]]) -> None:
    assert at_the_gate(make(take())).ok


def test_grey_levels_do_not_pass_for_kelvin_by_the_user_s_word() -> None:
    finding = at_the_gate(with_telemetry(levels(ground(2), 65535), agc=True), "/dev/video0?unit=centikelvin")
    assert not finding.ok
    assert "says that AGC is on" in finding.detail
