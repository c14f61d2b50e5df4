"""Specification: nothing is learned from what is held out, and thresholds come from other folds."""

from __future__ import annotations

import numpy as np
import pytest

from tools.evaluate.folds import Alarm, Outcome, few_zones_folds, grouped_folds, random_folds, thresholds
from tools.evaluate.rates import area_m2
from tools.train.picture.hits import hit
from tools.train.picture.records import Box, Record
from tools.train.picture.samples import BACKGROUND, BURIED

GREY = np.zeros((64, 64), np.uint8)
RECORDS = [Record(f"{z}{s}", z, s, 2.0, (Box(32, 32, 10, 10, "buried"),), GREY) for z in "1379" for s in "AB"]


def outcome(name: str, score_of_mines: float, score_of_ground: float) -> Outcome:
    """Ten mines and ten windows with one score each."""
    truth = np.repeat([BURIED, BACKGROUND], 10)
    score = np.repeat([score_of_mines, score_of_ground], 10)
    p = np.column_stack((np.zeros(20), score, 1.0 - score))
    return Outcome(name, truth, p, [], 0, 0, (truth, p))


def test_no_fold_learns_from_what_it_holds_out() -> None:
    folds = [*grouped_folds(RECORDS), *random_folds(RECORDS, 1), *(fold for _, fold in few_zones_folds(RECORDS))]
    assert not any((fold.held_out & fold.known).any() for fold in folds)
    assert all(fold.held_out.any() for fold in grouped_folds(RECORDS))


def test_a_fold_s_own_scores_do_not_choose_its_threshold() -> None:
    low, high = outcome("zone 1", 0.2, 0.1), outcome("zone 3", 0.9, 0.6)
    of_low, of_high = thresholds([low, high])
    assert of_low > 0.2
    assert of_high <= 0.2
    assert low.figures(of_low)["mine"] == 0.0


def test_sessions_choose_no_threshold_for_zones() -> None:
    folds = [outcome("zone 1", 0.9, 0.1), outcome("zone 3", 0.8, 0.1), outcome("session A", 0.01, 0.0)]
    assert thresholds([*folds, outcome("session B", 0.5, 0.1)])[0] == pytest.approx(0.8)


def test_pd_is_read_off_where_so_many_false_alarms_a_picture_are_let_through() -> None:
    alarms = [Alarm(0.9, 0, 0, (0, 0, 1), True), Alarm(0.8, 0, -1, (0, 0, 1)), Alarm(0.7, 1, 0, (0, 0, 1), False)]
    truth, p = np.zeros(0, np.int64), np.zeros((0, 3))
    found = Outcome("zone 1", truth, p, alarms, 2, 2, (truth, p))
    assert found.pd_at(0.3) == 0.5
    assert found.pd_at(0.5) == 1.0
    assert found.pd_at(0.5, strict=True) == 0.5


def test_mines_are_found_at_the_threshold_that_lets_so_many_false_alarms_through() -> None:
    alarms = [Alarm(0.9, 0, 0, (0, 0, 1)), Alarm(0.8, 0, -1, (0, 0, 1)), Alarm(0.7, 1, 0, (0, 0, 1))]
    truth, p = np.zeros(0, np.int64), np.zeros((0, 3))
    found = Outcome("zone 1", truth, p, alarms, 2, 2, (truth, p), (0, 1))
    assert found.found_at(0.3) == {(0, 0)}
    assert found.found_at(0.5) == {(0, 0), (1, 0)}
    assert [len(found.found_at(r)) / found.mines for r in (0.3, 0.5)] == [found.pd_at(r) for r in (0.3, 0.5)]


def test_ground_that_a_picture_shows_grows_with_the_square_of_the_height() -> None:
    low, high = (Record("a", "1", "A", height, (), GREY) for height in (2.0, 4.0))
    assert area_m2(low) == pytest.approx(1.06, abs=0.01)
    assert area_m2(high) == pytest.approx(4.0 * area_m2(low))


def test_a_detection_counts_in_the_box_and_in_its_halo() -> None:
    record = RECORDS[0]
    assert hit(record, (32.0, 36.9)) == 0
    assert hit(record, (32.0, 40.0)) == 0
    assert hit(record, (32.0, 41.0)) == -1
    assert hit(record, (32.0, 40.0), around=0.0) == -1
