"""Clutter has a cause: it changes over the day as the heat model says, and weather moves it within minutes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover_hil.ground.clutter import lay_clutter, spectral_noise
from rover_hil.ground.heat import Case, simulate
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CLEAR_DAY, SOILS
from rover_hil.ground.things import at_hour
from rover_hil.ground.weather import cloud_layer, lay_dew, shadow_layers, step_response, wind_layer
from rover_hil.world.catalogue import EFFECTS

GRID = Grid(-0.6, -0.6, 0.01, 240, 280)
LOAM = SOILS["loam"]


def sizes(effect: str, **changed: float) -> dict[str, float]:
    return {**{name: size.default for name, size in EFFECTS[effect].sizes.items()}, **changed}


def pattern(hour: float, seed: int = 1, **changed: float) -> np.ndarray:
    laid = lay_clutter(GRID, LOAM, hour, sizes("ground.clutter", **changed), np.random.default_rng(seed))
    return laid.temperature - laid.temperature.mean()


def alike(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.corrcoef(one.ravel(), other.ravel())[0, 1])


def test_two_visits_at_one_hour_see_one_pattern_and_day_and_night_see_two() -> None:
    assert np.array_equal(pattern(13.0), pattern(13.0))
    assert alike(pattern(11.0), pattern(13.0)) > 0.95
    assert alike(pattern(13.0), pattern(22.0)) < 0.7
    assert abs(alike(pattern(13.0), pattern(13.0, seed=2))) < 0.2


def test_soil_with_one_cause_follows_the_heat_model_to_its_sign() -> None:
    none = {"albedo": 0.0, "moisture": 0.0, "heat_capacity": 0.0, "roughness": 0.0, "vegetation": 0.0}
    assert alike(pattern(13.0, 1, **none), pattern(5.0, 1, **none)) < -0.99, "cool by day, warm by night"
    bright = {**none, "conductivity": 0.0, "albedo": 0.01}
    history = simulate([Case(LOAM), Case(type(LOAM)(LOAM.conductivity, LOAM.heat_capacity, LOAM.albedo + 0.01))])
    expected = float(np.diff(history.at(13.0)[:, 0])[0])
    assert pattern(13.0, 1, **bright).std() == pytest.approx(abs(expected), rel=0.02)


def test_its_spectrum_has_most_of_its_power_above_8_cm_as_real_soil_has() -> None:
    noise = spectral_noise(GRID, np.random.default_rng(5))
    power = np.abs(np.fft.rfft2(noise)) ** 2
    rows, columns = np.fft.fftfreq(GRID.rows, GRID.resolution), np.fft.rfftfreq(GRID.columns, GRID.resolution)
    wave = np.hypot(rows[:, None], columns[None, :])
    assert power[wave < 1 / 0.16].sum() > 2.0 * power[wave >= 1 / 0.16].sum()


def test_the_answer_to_a_step_begins_with_the_root_of_time_and_ends_where_loss_equals_gain() -> None:
    response = step_response(LOAM, CLEAR_DAY, 400_000)
    inertia = math.sqrt(LOAM.conductivity * LOAM.heat_capacity)
    assert response[4] == pytest.approx(2.0 * math.sqrt(4.0 / math.pi) / inertia, rel=0.03)
    assert response[-1] == pytest.approx(1.0 / 17.4, rel=0.1)


def test_clouds_move_the_ground_by_kelvins_by_day_and_not_at_all_at_night() -> None:
    even = np.ones(GRID.shape, np.float32)
    day = cloud_layer(even, LOAM, 13.0, sizes("weather.clouds"), 900, np.random.default_rng(1))
    night = cloud_layer(even, LOAM, 23.0, sizes("weather.clouds"), 900, np.random.default_rng(1))
    assert day.series[0] == 0.0
    assert np.ptp(day.series) > 1.0
    assert not night.series.any()


def test_gusts_cool_warm_ground_and_warm_cold_ground() -> None:
    even = np.ones(GRID.shape, np.float32)

    def gusts(hour: float) -> np.ndarray:
        rng = np.random.default_rng(1)
        return wind_layer(even, LOAM, at_hour(LOAM, hour), hour, sizes("weather.wind"), 300, rng).series

    assert 0.05 < np.ptp(gusts(13.0)) < 5.0
    assert np.corrcoef(gusts(13.0), gusts(5.0))[0, 1] < -0.9


def test_shadows_wander_with_the_sun_from_west_to_east() -> None:
    rng = np.random.default_rng(3)
    found = shadow_layers(GRID, (1.2, 1.6), LOAM, 13.0, sizes("weather.shadows", trees=5), 1200, rng)
    shade, layers = found
    assert shade.min() < -3.0
    assert shade.max() <= 0.0
    later = shade + layers[-1].raster
    x = np.arange(GRID.columns)[None, :]
    assert (x * later).sum() / later.sum() > (x * shade).sum() / shade.sum()
    assert all(layer.series[0] == 0.0 for layer in layers)


def test_dew_evens_the_ground_out_before_sunrise_and_is_gone_at_noon() -> None:
    dewy, dry = pattern(5.0), pattern(13.0)
    before = dewy.std()
    lay_dew(dewy, GRID, 5.0, 0.6, np.random.default_rng(1))
    assert dewy.std() < 0.7 * before
    unchanged = dry.copy()
    lay_dew(dry, GRID, 13.0, 0.6, np.random.default_rng(1))
    assert np.array_equal(dry, unchanged)
