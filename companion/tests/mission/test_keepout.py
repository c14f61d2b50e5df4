"""Keep-out zones: from suspicion to dismissal, and the record of both."""

from __future__ import annotations

from dataclasses import dataclass

from rover.detection.place import Anchor
from rover.mission.keepout import REDRAW_DISTANCE, KeepOut, Zone


@dataclass(frozen=True)
class Place:
    id: int
    x: float
    y: float
    anchor: Anchor | None = None


def test_a_zone_stands_from_the_moment_of_suspicion() -> None:
    keepout = KeepOut(0.15)
    assert keepout.update([Place(4, 1.0, 2.0)], 3.0)
    assert keepout.active == [Zone(4, 1.0, 2.0, 0.15, since=3.0, until=None)]


def test_a_suspicion_that_stays_leaves_its_zone_as_it_is() -> None:
    keepout = KeepOut(0.15)
    keepout.update([Place(1, 1.0, 2.0)], 3.0)
    assert not keepout.update([Place(1, 1.0 + 0.9 * REDRAW_DISTANCE, 2.0)], 4.0)
    assert keepout.history == [Zone(1, 1.0, 2.0, 0.15, 3.0)]


def test_a_place_that_has_moved_draws_its_zone_anew_without_a_gap_between_the_two() -> None:
    keepout = KeepOut(0.15)
    keepout.update([Place(1, 1.0, 2.0)], 3.0)
    assert keepout.update([Place(1, 1.05, 2.0)], 4.0)
    assert keepout.active == [Zone(1, 1.05, 2.0, 0.15, 4.0)]
    assert keepout.history == [Zone(1, 1.0, 2.0, 0.15, 3.0, until=4.0), Zone(1, 1.05, 2.0, 0.15, 4.0)]


def test_a_place_cannot_creep_away_from_its_zone_in_small_steps() -> None:
    keepout = KeepOut(0.15)
    for step in range(40):
        x = 1.0 + 0.004 * step
        keepout.update([Place(1, x, 2.0)], float(step))
        assert abs(keepout.active[0].x - x) < REDRAW_DISTANCE


def test_dismissal_ends_the_zone_and_a_new_suspicion_starts_another() -> None:
    keepout = KeepOut(0.15)
    keepout.update([Place(1, 1.0, 2.0), Place(2, 2.0, 2.0)], 3.0)
    assert keepout.update([Place(2, 2.0, 2.0)], 5.0)
    assert [zone.id for zone in keepout.active] == [2]
    keepout.update([Place(1, 1.0, 2.0), Place(2, 2.0, 2.0)], 7.0)
    assert [(zone.id, zone.since, zone.until) for zone in keepout.history] == [
        (1, 3.0, 5.0),
        (2, 3.0, None),
        (1, 7.0, None),
    ]


def test_zones_come_in_the_order_of_their_places_whatever_order_they_arose_in() -> None:
    keepout = KeepOut(0.15)
    keepout.update([Place(number, float(number), 0.0) for number in (9, 2, 5)], 1.0)
    assert [zone.id for zone in keepout.active] == [2, 5, 9]


def test_nothing_suspected_means_no_zones_and_no_change() -> None:
    keepout = KeepOut(0.15)
    assert not keepout.update([], 1.0)
    assert (keepout.active, keepout.history) == ([], [])
