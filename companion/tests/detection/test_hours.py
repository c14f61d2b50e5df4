"""Specification: who surveys when mines hardly show is told so, with the next hour at which they do."""

from __future__ import annotations

import pytest
from rover.detection.hours import GOOD_K, HARDLY_K, typical, warning
from rover.mission.preflight import judge_hour


@pytest.mark.parametrize(("hour", "good"), [(7.5, "09:30"), (17.5, "21:00"), (18.0, "21:00"), (8.25, "09:30")])
def test_near_the_zero_crossings_the_next_good_hour_is_named(hour: float, good: str) -> None:
    assert f"the next good hour is {good}" in warning(hour)
    (finding,) = judge_hour(hour)
    assert finding.ok


@pytest.mark.parametrize("hour", [0.0, 3.0, 10.0, 13.0, 15.9, 22.0, 23.99])
def test_at_other_hours_nothing_is_said(hour: float) -> None:
    assert warning(hour) == ""
    assert list(judge_hour(hour)) == []


def test_every_hour_is_warned_of_exactly_where_the_contrast_is_small_and_the_named_hour_is_good() -> None:
    for minutes in range(0, 1440, 10):
        hour = minutes / 60.0
        said = warning(hour)
        assert bool(said) == (abs(typical(hour)[2]) < HARDLY_K)
        if said:
            named = said.partition("hour is ")[2][:5]
            assert abs(typical(int(named[:2]) + int(named[3:]) / 60.0)[2]) >= GOOD_K


def test_the_day_ends_as_it_begins() -> None:
    assert typical(24.0) == typical(0.0)
