"""Specification: the maps of two surveys are laid on each other, though what was warm is cold at another hour."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.vision.localization.keyframe_map import KeyframeMap, SubmapRecord
from rover.vision.localization.keyframes import Keyframe
from rover.vision.localization.map_registration import register_maps

RESOLUTION = 0.02
SIDE = 150
HERE = Pose2(0.0, 0.0, 0.0)
NOTHING = KeyframeMap([], [], [], [], Pose2(0.0, 0.0, 0.0), (0.01, 0.01, 0.01), 0)


def stones(seed: int, shift: Pose2 = HERE, sign: float = 1.0) -> np.ndarray:
    """A mosaic of 3 m whose things lie where `shift` takes them, warmer or colder than what is around them."""
    rng = np.random.default_rng(seed)
    y, x = (np.mgrid[0:SIDE, 0:SIDE] + 0.5) * RESOLUTION
    kelvin = np.full((SIDE, SIDE), 290.0)
    things = np.column_stack((rng.uniform(0, 3, (60, 2)), rng.uniform(0.02, 0.06, 60), rng.normal(0, 1, 60)))
    for px, py, size, k in things.tolist():
        at = shift.transform(np.array([[px, py]]))[0]
        kelvin += sign * k * np.exp(-0.5 * ((x - at[0]) ** 2 + (y - at[1]) ** 2) / size**2)
    noise = np.random.default_rng(seed + 100 + int(sign)).normal(0, 0.05, kelvin.shape)
    return (kelvin + noise).astype(np.float32)


def off(found: Pose2, true: Pose2) -> float:
    """Largest distance between where both put the corners of the field, metres."""
    corners = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])
    return float(np.hypot(*(found.transform(corners) - true.transform(corners)).T).max())


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("shift", [Pose2(0.08, -0.06, 0.0), Pose2(-0.1, 0.12, math.radians(1.0))])
def test_mosaics_alone_tell_how_the_maps_lie(shift: Pose2, sign: float) -> None:
    found = register_maps(NOTHING, stones(1), NOTHING, stones(1, shift, sign), RESOLUTION, False)
    assert found.by == "mosaics"
    assert np.sign(found.agreement) == sign
    assert off(found.shift, shift) < 0.03


def test_ground_that_has_nothing_in_common_is_left_where_the_launch_puts_it() -> None:
    found = register_maps(NOTHING, stones(1), NOTHING, stones(2), RESOLUTION, False)
    assert (found.by, found.shift) == ("the launch", Pose2(0.0, 0.0, 0.0))


def test_a_map_that_plates_hold_says_so() -> None:
    assert register_maps(NOTHING, stones(1), NOTHING, stones(1), RESOLUTION, True).by == "marker plates"


def test_keyframes_whose_features_match_tell_it_too() -> None:
    rng = np.random.default_rng(5)
    shift = Pose2(0.05, 0.04, math.radians(0.7))
    ground = rng.uniform(0.2, 2.8, (200, 2))
    descriptors = rng.integers(0, 256, (200, 32), dtype=np.uint8)
    seen = shift.transform(ground) + rng.normal(0, 0.005, ground.shape)
    noisy = descriptors ^ (1 << rng.integers(0, 8, descriptors.shape)).astype(np.uint8) * (rng.random((200, 32)) < 0.3)
    empty = np.full((SIDE, SIDE), np.nan, np.float32)
    first, second = (_map(points, told) for points, told in ((ground, descriptors), (seen, noisy.astype(np.uint8))))
    by_features = register_maps(first, stones(1), second, stones(1, shift), RESOLUTION, False)
    assert off(by_features.shift, shift) < 0.02
    assert register_maps(first, empty, second, empty, RESOLUTION, False).by == "the launch"


def _map(ground: np.ndarray, descriptors: np.ndarray) -> KeyframeMap:
    frame = Keyframe(ground, descriptors, np.full(len(ground), 0.005), 0.0)
    submap = SubmapRecord([frame], np.zeros((1, 3)), 1e-4 * np.eye(3))
    return KeyframeMap([submap], [Pose2(0.0, 0.0, 0.0)], [], [], Pose2(0.0, 0.0, 0.0), (0.01, 0.01, 0.01), 0)
