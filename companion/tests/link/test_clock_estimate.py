"""The companion knows the firmware's clock through jitter, drift and the wrap of 32 bits."""

from __future__ import annotations

import numpy as np
import pytest
from rover.link.baud import DEFAULT_BAUD
from rover.link.clock_estimate import ClockEstimate
from rover.link.unwrap import ahead, unwrap


def exchange(
    estimate: ClockEstimate, sent: float, up: float, down: float, offset_us: float, drift: float = 0.0
) -> None:
    at_us = round((sent + up) * 1e6 * (1.0 + drift) + offset_us)
    estimate.add(sent, sent + up + down, at_us & 0xFFFF_FFFF, 0, 0, 0)


def test_a_single_exchange_gives_the_offset() -> None:
    estimate = ClockEstimate()
    exchange(estimate, 1.0, 0.0005, 0.0005, offset_us=7_000_000)
    assert estimate.to_firmware(2.0) == pytest.approx(9_000_000, abs=2)
    assert estimate.to_companion(9_000_000) == pytest.approx(2.0, abs=2e-6)


def test_the_wires_own_time_is_not_taken_for_delay() -> None:
    estimate = ClockEstimate()
    up, down = 8 * 10 / DEFAULT_BAUD, 14 * 10 / DEFAULT_BAUD
    at_us = round((1.0 + up) * 1e6)
    estimate.add(1.0, 1.0 + up + down, at_us, 0, up, down)
    assert estimate.to_firmware(5.0) == pytest.approx(5_000_000, abs=2)


def test_a_millisecond_of_jitter_leaves_under_100_us_of_error() -> None:
    rng = np.random.default_rng(5)
    estimate = ClockEstimate()
    errors = []
    drift, offset = 40e-6, 123_456_789.0
    for step in range(400):
        sent = 0.5 * step
        up, down = 0.0004 + rng.exponential(0.001, 2)
        exchange(estimate, sent, up, down, offset, drift)
        if step > 20:
            errors.append(abs(estimate.to_firmware(sent + 0.7) - ((sent + 0.7) * 1e6 * (1.0 + drift) + offset)))
    assert np.median(errors) < 100.0
    assert estimate.drift == pytest.approx(drift, abs=15e-6)


def test_an_outlier_does_not_move_the_estimate() -> None:
    estimate = ClockEstimate()
    for step in range(20):
        exchange(estimate, 0.5 * step, 0.0005, 0.0005, offset_us=0)
    before = estimate.to_firmware(20.0)
    exchange(estimate, 10.5, 0.3, 0.0005, offset_us=0)
    assert abs(estimate.to_firmware(20.0) - before) < 5


def test_time_goes_on_past_the_wrap_of_32_bits() -> None:
    estimate = ClockEstimate()
    offset = 2**32 - 3_000_000
    for step in range(20):
        exchange(estimate, 0.5 * step, 0.0005, 0.0005, offset_us=offset)
    assert estimate.to_firmware(9.0) == pytest.approx(offset + 9_000_000, abs=5)
    raw_ms = (offset + 8_000_000) // 1000 & 0xFFFF
    assert estimate.stamp(raw_ms, 8.003, unit_us=1000, bits=16) == pytest.approx(8.0, abs=0.001)


def test_before_the_first_exchange_a_stamp_is_the_time_of_arrival() -> None:
    """A firmware that has run for a minute must not have its first words dated a minute ahead."""
    estimate = ClockEstimate()
    assert estimate.stamp(60_000, 1.25, unit_us=1000, bits=16) == 1.25


def test_error_bound_covers_half_the_unexplained_round_trip() -> None:
    estimate = ClockEstimate()
    exchange(estimate, 1.0, 0.001, 0.003, offset_us=0)
    true_error = abs(estimate.to_firmware(1.0) - 1_000_000) * 1e-6
    assert true_error == pytest.approx(0.001, abs=1e-5)
    assert true_error <= estimate.error_bound < 0.0025


def test_counters_unwrap_to_the_nearest_value() -> None:
    assert unwrap(2, 16, 65_535) == 65_538
    assert unwrap(65_535, 16, 65_538) == 65_535
    assert unwrap(-8_388_608, 24, 8_388_607) == 8_388_608
    assert ahead(1, 65_535) == 2
    assert ahead(65_535, 1) == -2
