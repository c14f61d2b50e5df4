"""After which stops by the firmware a mission goes on, and how often."""

from __future__ import annotations

import pytest
from rover.link.words import StopCause
from rover.mission.field import FULL_FIELD_M2
from rover.mission.stops import MAX_REARMS, Stops
from rover.outcome import RunStatus


@pytest.mark.parametrize("cause", StopCause)
def test_a_mission_goes_on_as_often_as_the_table_says_and_no_more(cause: StopCause) -> None:
    stops = Stops()
    for _ in range(MAX_REARMS.get(cause, 0)):
        stops.add(str(cause.value))  # as the wire says it
        assert not stops.too_many(cause.value)
    stops.add(cause.value)
    assert stops.too_many(cause.value)


def test_stops_of_one_cause_do_not_count_for_another() -> None:
    stops = Stops()
    for _ in range(MAX_REARMS[StopCause.STALL] + 1):
        stops.add(StopCause.STALL)
    stops.add(StopCause.SONAR_GUARD)
    assert stops.too_many(StopCause.STALL)
    assert not stops.too_many(StopCause.SONAR_GUARD)


@pytest.mark.parametrize("cause", [StopCause.EMERGENCY_INPUT, StopCause.LOW_BATTERY, StopCause.ENCODER_FAULT])
def test_nobody_rearms_after_a_button_an_empty_battery_or_a_broken_encoder(cause: StopCause) -> None:
    assert cause not in MAX_REARMS


def test_an_empty_battery_leaves_a_mission_to_go_on_with_and_anything_else_is_a_safety_stop() -> None:
    statuses = {cause: Stops().outcome(cause).status for cause in StopCause}
    assert statuses.pop(StopCause.LOW_BATTERY) is RunStatus.PARTIAL
    assert set(statuses.values()) == {RunStatus.SAFETY_STOP}


def test_a_cause_that_this_version_does_not_know_ends_the_mission() -> None:
    stops = Stops()
    stops.add("13")
    assert stops.too_many("13")


def test_a_larger_field_has_more_of_what_its_ground_brings_and_not_of_what_the_machine_does() -> None:
    small, large = Stops(FULL_FIELD_M2), Stops(10.0 * FULL_FIELD_M2)
    for cause in (StopCause.SONAR_GUARD, StopCause.STALL):
        for stops in (small, large):
            for _ in range(MAX_REARMS[cause] + 1):
                stops.add(cause)
        assert small.too_many(cause)
    assert not large.too_many(StopCause.SONAR_GUARD)
    assert large.too_many(StopCause.STALL)
