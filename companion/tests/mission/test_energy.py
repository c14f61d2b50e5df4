"""What is left in a battery, by its voltage."""

from __future__ import annotations

import numpy as np
import pytest
from rover.link.telemetry import Battery
from rover.mission.energy import MARGIN, OPEN_CIRCUIT, Gauge, charge_of, way_back_s
from rover.vehicle import Pack

PACK = Pack()


def gauge(volts: float, seconds: float = 10.0) -> Gauge:
    watched = Gauge(PACK)
    for time in np.arange(0.0, seconds, 0.5):
        watched.take(Battery(float(time), volts, volts))
    return watched


def test_the_charge_goes_through_the_points_of_its_curve_and_never_falls_with_the_voltage() -> None:
    assert [charge_of(volts) for _, volts in OPEN_CIRCUIT] == pytest.approx([charge for charge, _ in OPEN_CIRCUIT])
    charges = [charge_of(volts) for volts in np.linspace(2.0, 5.0, 301)]
    assert charges == sorted(charges)
    assert (charges[0], charges[-1]) == (0.0, 1.0)


def test_nothing_is_said_of_a_voltage_that_was_only_just_seen() -> None:
    assert Gauge(PACK).left_wh is None
    assert gauge(7.4, 1.0).left_wh is None
    assert not gauge(5.0, 1.0).spent(1000.0)


def test_at_the_firmwares_limit_nothing_is_left() -> None:
    assert gauge(PACK.low_v).left_wh == pytest.approx(0.0, abs=0.05)


def test_a_full_pack_holds_about_what_it_is_made_for() -> None:
    left = gauge(8.4).left_wh
    assert left is not None
    assert 0.85 * PACK.capacity_wh < left <= PACK.capacity_wh


def test_what_is_left_lasts_as_long_as_the_rover_draws_its_power() -> None:
    watched = gauge(7.4)
    assert watched.left_s is not None
    assert watched.left_wh == pytest.approx(watched.left_s / 3600.0 * PACK.power_w)


def test_the_reserve_is_the_way_back_with_half_of_it_in_hand() -> None:
    watched = gauge(6.5)
    assert watched.left_s is not None
    assert not watched.spent(0.99 * watched.left_s / MARGIN)
    assert watched.spent(1.01 * watched.left_s / MARGIN)


def test_a_longer_way_takes_longer() -> None:
    assert way_back_s(10.0, 0.25) == way_back_s(5.0, 0.25) + 20.0
