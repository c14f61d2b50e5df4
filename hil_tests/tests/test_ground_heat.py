"""The heat model against the reference contrasts, and against what conduction must do whatever the constants."""

from __future__ import annotations

import time

import numpy as np
import pytest
from rover.errors import BadInput
from rover_hil.ground.heat import Case, Inclusion, simulate
from rover_hil.ground.raster import Grid
from rover_hil.ground.signature import (
    contrast_table,
    daily_contrasts,
    lay_signature,
    mine_case,
    signature,
    zero_crossings,
)
from rover_hil.ground.soils import CLEAR_DAY, REFERENCE_SOIL, SOILS, soil_named

DEPTHS = (0.01, 0.02, 0.05, 0.10)
REFERENCE_DAY = (4.3, 2.8, 0.9, 0.2)
REFERENCE_NIGHT = (-2.3, -1.6, -0.55, -0.13)


@pytest.fixture(scope="module")
def reference():
    return daily_contrasts(REFERENCE_SOIL, DEPTHS)


def test_the_reference_soil_has_the_reference_diffusivity_and_damping_depth():
    soil = SOILS[REFERENCE_SOIL]
    assert soil.diffusivity == pytest.approx(5e-7)
    assert min(s.damping_depth for s in SOILS.values()) >= 0.08
    assert max(s.damping_depth for s in SOILS.values()) <= 0.14


def test_contrasts_by_day_and_night_match_the_reference_within_a_fifth(reference):
    centre = reference.contrast.temperature[:, 0]
    np.testing.assert_allclose(centre.max(axis=1), REFERENCE_DAY, rtol=0.20)
    np.testing.assert_allclose(centre.min(axis=1), REFERENCE_NIGHT, rtol=0.20)


def test_the_contrast_at_one_centimetre_vanishes_in_the_morning_and_in_the_afternoon(reference):
    morning, afternoon = zero_crossings(reference.contrast.hour, reference.contrast.temperature[0, 0])
    assert morning == pytest.approx(7.2, abs=0.25)
    assert afternoon == pytest.approx(17.0, abs=0.25)


def test_deeper_mines_show_less_and_later(reference):
    centre = reference.contrast.temperature[:, 0]
    assert np.all(np.diff(centre.max(axis=1)) < 0)
    assert np.all(np.diff(reference.contrast.hour[centre.argmax(axis=1)]) > 0)


def test_a_mine_in_dry_sand_nearly_vanishes():
    sand = daily_contrasts("dry-sand", (0.01, 0.05)).contrast.temperature[:, 0]
    assert np.abs(sand[0]).max() < 0.5
    assert np.abs(sand[1]).max() < 0.1


def test_a_contrast_fades_with_the_distance_from_the_mine():
    profile = signature("loam", 0.02, 12.0, [0.0, 0.05, 0.10, 0.20, 0.35, 0.8])
    assert np.all(np.diff(profile) <= 0.005)
    assert profile[0] > 2.0
    assert abs(profile[3]) < 0.05
    assert profile[-1] == 0.0


def test_an_inclusion_of_the_same_soil_changes_nothing():
    soil = SOILS["clay"]
    bare, filled = simulate([Case(soil), Case(soil, Inclusion(soil, 0.055, 0.05, 0.02))]).temperature
    np.testing.assert_allclose(filled, bare, atol=1e-9)


def test_three_days_of_spin_up_are_enough_and_five_minutes_are_fine_enough():
    soil = SOILS["loam"]
    cases = [Case(soil), mine_case(soil, 0.01)]

    def contrast(**settings):
        history = simulate(cases, **settings)
        return np.array([(history.at(h)[1] - history.at(h)[0])[0] for h in (4.0, 9.0, 12.0, 18.0)])

    usual = contrast()
    np.testing.assert_allclose(contrast(spin_up_days=8), usual, atol=0.03)
    np.testing.assert_allclose(contrast(steps_per_day=1152), usual, atol=0.06)


def test_steady_weather_settles_where_the_surface_balance_is_zero():
    from dataclasses import replace

    dark = replace(CLEAR_DAY, noon_irradiance=0.0, air_amplitude=0.0)
    soil = SOILS["loam"]
    settled = simulate([Case(soil)], dark).temperature[0, 0, -1]
    balance = dark.convection * (dark.air_mean - settled)
    balance += soil.emissivity * 5.670374419e-8 * ((dark.air_mean - dark.sky_depression) ** 4 - settled**4)
    assert balance == pytest.approx(0.0, abs=1e-6)


def test_the_cases_of_a_whole_field_take_less_than_two_seconds():
    soil = SOILS["loam"]
    cases = [Case(soil), *(mine_case(soil, depth) for depth in (0.0, *DEPTHS))]
    start = time.process_time()
    simulate(cases)
    assert time.process_time() - start < 2.0


def test_a_signature_is_laid_where_the_mine_is():
    grid = Grid(-1.0, -0.5, 0.01, 200, 150)
    raster = np.zeros(grid.shape, dtype=np.float32)
    lay_signature(raster, grid, (0.205, 0.305), np.array([0.0, 0.1]), np.array([2.0, 0.0]))
    assert raster[80, 120] == pytest.approx(2.0)
    assert raster[80, 125] == pytest.approx(1.0, abs=1e-5)
    assert raster.sum() * 1e-4 == pytest.approx(2.0 * np.pi * 0.1**2 / 3, rel=0.01)


def test_the_same_days_are_simulated_to_the_same_bits():
    cases = [mine_case(SOILS["clay"], 0.02)]
    assert simulate(cases).temperature.tobytes() == simulate(cases).temperature.tobytes()


def test_an_unknown_soil_is_one_clear_line():
    with pytest.raises(BadInput, match="no soil is called 'chalk'"):
        soil_named("chalk")


def test_the_table_names_every_hour_and_the_extremes():
    lines = contrast_table("loam", step_hours=6.0).splitlines()
    assert lines[0].startswith("| hour | soil °C | surface | 1 cm")
    assert [line.split("|")[1].strip() for line in lines[2:]] == [
        *("00:00", "06:00", "12:00", "18:00"),
        *("highest", "lowest", "zero at"),
    ]
