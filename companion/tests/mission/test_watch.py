"""What brings the rover to rest whatever it is about."""

from __future__ import annotations

import pytest
from rover.mission.sight import BLIND_AFTER, LOST_AFTER
from rover.mission.watch import Watch
from rover.outcome import RunStatus


def test_the_time_limit_ends_the_mission_as_partial() -> None:
    watch = Watch(10.0)
    watch.take(100.0, [])
    assert watch.check(110.0, 0.01, False).end is None
    end = watch.check(110.1, 0.01, False).end
    assert end is not None
    assert (end.status, end.reason) == (RunStatus.PARTIAL, "the time limit of 10 s ran out")


def test_a_blind_rover_brakes_once_and_gives_up_in_the_end() -> None:
    watch = Watch(900.0)
    watch.take(0.0, [])
    notes = [note for tick in range(1, 200) for note in watch.check(0.05 * tick, 0.01, False).notes]
    assert notes == [f"the camera has shown nothing for {BLIND_AFTER:g} s: the rover waits for pictures"]
    assert watch.blind
    end = watch.check(LOST_AFTER + 0.1, 0.01, False).end
    assert end is not None
    assert end.status is RunStatus.PARTIAL


def test_a_lost_place_is_told_once_until_somebody_does_something_about_it() -> None:
    watch = Watch(900.0)
    watch.take(0.0, [])
    assert watch.check(0.1, 0.12, True).notes == ["the place is not known (1σ of 0.12 m): looking around"]
    assert watch.check(0.2, 0.12, True).notes == []
    watch.astray = False
    assert watch.check(0.3, 0.12, True).notes


@pytest.mark.parametrize("lost", [False, True])
def test_nothing_else_ends_a_mission(lost: bool) -> None:
    watch = Watch(900.0)
    watch.take(0.0, [])
    assert watch.check(1.0, 5.0, lost).end is None
