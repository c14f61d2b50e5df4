"""A gyroscope beside the wheels: the turn is its own, and a wheel that slips is found and taken back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera
from rover.vision.localization.localizer import Localizer

CAMERA = load_camera("lepton-160")
TRACK = 0.2
PERIOD = 0.02


def driven(
    seconds: float, speed: float, rate: float, slip: tuple[float, float], gyro: bool, noise: float = 0.0
) -> Localizer:
    """From the origin; `slip`: part of each wheel's way that the ground does not get."""
    localizer = Localizer(CAMERA, Pose2(0.0, 0.0, 0.0), (0.001, 0.001, 0.001))
    random = np.random.default_rng(5)
    for step in range(round(seconds / PERIOD) + 1):
        ground = (speed * PERIOD - 0.5 * rate * PERIOD * TRACK, speed * PERIOD + 0.5 * rate * PERIOD * TRACK)
        left, right = (0.0, 0.0) if step == 0 else (way / (1.0 - s) for way, s in zip(ground, slip, strict=True))
        turn = (0.0 if step == 0 else rate * PERIOD) + noise * float(random.normal())
        localizer.predict(step * PERIOD, left, right, turn if gyro else None)
    return localizer


def test_one_wheel_that_slips_leads_the_wheels_astray_and_not_the_gyroscope() -> None:
    """30 % of slip at the right wheel over 1 m: the wheels alone believe in a turn to the left."""
    without, with_one = (driven(4.0, 0.25, 0.0, (0.0, 0.3), gyro).pose for gyro in (False, True))
    assert abs(without.heading) > 1.0
    assert abs(with_one.heading) < 1e-9
    assert math.hypot(with_one.x - 1.0, with_one.y) < 0.005


@pytest.mark.parametrize("slip", [(0.3, 0.0), (0.0, 0.3)])
@pytest.mark.parametrize(("speed", "rate"), [(0.25, 0.0), (0.2, 0.5), (-0.2, 0.0)])
def test_the_slipping_wheel_is_the_one_that_has_rolled_too_far(
    speed: float, rate: float, slip: tuple[float, float]
) -> None:
    sound, slipping = driven(2.0, speed, rate, (0.0, 0.0), True).pose, driven(2.0, speed, rate, slip, True).pose
    assert sound.distance(slipping) < 0.005
    assert abs(sound.heading - slipping.heading) < 1e-9


def test_the_heading_is_surer_with_a_gyroscope_and_the_covariance_stays_one() -> None:
    without, with_one = (driven(4.0, 0.25, 0.3, (0.0, 0.0), gyro).covariance for gyro in (False, True))
    assert with_one[2, 2] < 0.3 * without[2, 2]
    assert np.linalg.eigvalsh(with_one).min() > 0.0


def test_without_one_nothing_is_different() -> None:
    plain = driven(1.0, 0.2, 0.3, (0.01, 0.0), gyro=False)
    again = Localizer(CAMERA, Pose2(0.0, 0.0, 0.0), (0.001, 0.001, 0.001))
    again.predict(0.0, 0.0, 0.0)
    for step in range(1, 51):
        again.predict(step * PERIOD, (0.2 - 0.03) * PERIOD / 0.99, (0.2 + 0.03) * PERIOD)
    assert plain.pose.distance(again.pose) < 1e-12
