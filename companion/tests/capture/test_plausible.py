"""Pictures in kelvin are believed; what a camera with the wrong settings delivers is named for what it is."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from rover.capture.cptv import CptvSource
from rover.capture.frame import Frame
from rover.capture.plausible import MAX_JUMP_K, doubt, doubts

Counts = NDArray[np.uint16]


def ground(
    seed: int = 0, middle_k: float = 293.0, contrast_k: float = 4.0, shape: tuple[int, int] = (120, 160)
) -> Counts:
    """Synthetic ground: smooth patches of `contrast_k`, 50 mK of noise; kelvin × 100."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    waves = sum(
        np.sin(x * rng.uniform(0.01, 0.2) + y * rng.uniform(0.01, 0.2) + rng.uniform(0, 6.0)) for _ in range(5)
    )
    kelvin = middle_k + contrast_k * waves / 5.0 + rng.normal(0.0, 0.05, shape)
    return np.asarray(np.round(kelvin * 100.0), np.uint16)


def stretched(counts: Counts, largest: int) -> Counts:
    low, high = int(counts.min()), int(counts.max())
    return np.asarray((counts.astype(np.float64) - low) / (high - low) * largest, np.uint16)


def equalized(counts: Counts, largest: int) -> Counts:
    rank = np.argsort(np.argsort(counts, axis=None)).reshape(counts.shape)
    return np.asarray(rank / rank.max() * largest, np.uint16)


def raw(counts: Counts) -> Counts:
    """As a sensor counts: about 30 a kelvin, around its own offset."""
    return np.asarray(7800.0 + (counts.astype(np.float64) - 29300.0) * 0.3, np.uint16)


WRONG: dict[str, tuple[Callable[[Counts], Counts], str]] = {
    "raw 14 bits": (raw, "raw counts of 14 bits"),
    "AGC, 8 bits in 16": (lambda c: stretched(c, 255), "switch AGC off"),
    "AGC, equalized": (lambda c: equalized(c, 255), "switch AGC off"),
    "AGC in the upper byte": (lambda c: np.asarray(stretched(c, 255) << 8, np.uint16), "switch AGC off"),
    "AGC in both bytes": (lambda c: np.asarray(stretched(c, 255) * 257, np.uint16), "switch AGC off"),
    "AGC over 16 bits": (lambda c: stretched(c, 65535), "switch AGC off"),
    "AGC over 16 bits, equalized": (lambda c: equalized(c, 65535), "switch AGC off"),
    "bytes swapped": (lambda c: c.byteswap(), "bytes of each pixel are swapped"),
    "raw, bytes swapped": (lambda c: raw(c).byteswap(), "bytes of each pixel are swapped"),
    "tenths of a kelvin": (lambda c: np.asarray(np.round(c / 10.0), np.uint16), "tenths of a kelvin"),
    "Celsius × 100": (lambda c: np.asarray(c - 27315, np.uint16), "no temperatures"),
    "nothing": (lambda c: np.zeros_like(c), "no temperatures"),
    "everything": (lambda c: np.full_like(c, 65535), "no temperatures of ground"),
    "a furnace": (lambda c: np.asarray(c + 20000, np.uint16), "°C are no temperatures of ground"),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("middle_k", "contrast_k"), [(250.0, 1.0), (280.0, 0.2), (293.0, 4.0), (318.0, 15.0), (335.0, 20.0)]
)
def test_ground_is_believed_from_frost_to_summer(seed: int, middle_k: float, contrast_k: float) -> None:
    assert doubt(ground(seed, middle_k, contrast_k), 0.01) is None


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("contrast_k", [1.0, 4.0, 12.0])
@pytest.mark.parametrize(("make", "name"), WRONG.values(), ids=WRONG.keys())
def test_what_is_no_temperature_is_named(
    make: Callable[[Counts], Counts], name: str, seed: int, contrast_k: float
) -> None:
    assert name in (doubt(make(ground(seed, 298.0, contrast_k)), 0.01) or "believed")


def test_each_unit_is_named_to_the_other() -> None:
    tenths = np.asarray(np.round(ground() / 10.0), np.uint16)
    assert doubt(tenths, 0.1) is None
    assert "the source's unit is decikelvin" in (doubt(tenths, 0.01) or "")
    assert "the source's unit is centikelvin" in (doubt(ground(), 0.1) or "")
    assert "switch TLinear on" in (doubt(raw(ground()), None) or "")


def test_a_hot_stone_and_a_dead_row_are_no_reason_for_doubt() -> None:
    counts = ground()
    counts[50:58, 60:70] = 45000
    counts[3, :100] = 0
    assert doubt(counts, 0.01) is None


@given(st.floats(240.0, 350.0), st.floats(0.0, 20.0), st.integers(0, 100))
def test_no_ground_within_bounds_is_doubted(middle_k: float, contrast_k: float, seed: int) -> None:
    assert doubt(ground(seed, middle_k, min(contrast_k, 365.0 - middle_k, middle_k - 225.0), (60, 80)), 0.01) is None


def frames(*middles_k: float) -> list[Frame]:
    return [Frame(ground(7, middle), 0.1 * number, number) for number, middle in enumerate(middles_k)]


def test_a_jump_between_two_pictures_is_doubted_and_a_change_of_light_is_not() -> None:
    assert doubts(frames(293.0, 293.2, 299.0, 305.0)) is None
    assert f"change by +{MAX_JUMP_K + 1:.0f} K" in (doubts(frames(290.0, 290.0, 291.0 + MAX_JUMP_K)) or "")


def test_what_is_behind_the_shutter_is_not_looked_at() -> None:
    closed = replace(frames(330.0)[0], ffc=True)
    assert doubts([*frames(293.0), closed, *frames(293.0)]) is None


REAL = {
    "raw": (lambda c: c, "raw counts of 14 bits"),
    "AGC in 8 bits": (lambda c: stretched(c, 255), "switch AGC off"),
    "AGC in 16 bits": (lambda c: stretched(c, 65535), "switch AGC off"),
    "AGC in 16 bits, equalized": (lambda c: equalized(c, 65535), "switch AGC off"),
    "raw, swapped": (lambda c: c.byteswap(), "swapped"),
    "kelvin × 100, swapped": (lambda c: in_kelvin(c, 100.0).byteswap(), "swapped"),
    "0.1 K": (lambda c: in_kelvin(c, 10.0), "tenths of a kelvin"),
    "kelvin × 100": (lambda c: in_kelvin(c, 100.0), "believed"),
}


def in_kelvin(counts: Counts, per_kelvin: float) -> Counts:
    """Of a Lepton's raw counts, at 0.03 K each."""
    kelvin = 293.0 + 0.03 * (counts.astype(np.float64) - np.median(counts))
    return np.asarray(np.round(kelvin * per_kelvin), np.uint16)


@pytest.mark.parametrize(("make", "name"), REAL.values(), ids=REAL.keys())
def test_a_real_lepton_s_pictures_are_named(make: Callable[[Counts], Counts], name: str) -> None:
    data = os.environ.get("ROVER_DATA")
    if not data:
        pytest.skip("ROVER_DATA is not set: the recording is not part of the project")
    for frame in islice(CptvSource(str(Path(data) / "lepton" / "v2.cptv")), 0, 60, 20):
        assert name in (doubt(make(frame.counts), 0.01) or "believed")
