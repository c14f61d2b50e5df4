"""Specification: what counts how much when the network for pictures learns, and which weights it keeps."""

from __future__ import annotations

import numpy as np
import pytest
from rover.detection.picture.patch import LENGTH

from tools.train.network import fit
from tools.train.picture.augment import MAX_ZOOM, MIN_ZOOM, from_another_height
from tools.train.picture.flights import flights, rate
from tools.train.picture.hits import Loudness
from tools.train.picture.recipe import DRAWN_SHARE, GROUND_WEIGHT, SURFACE_SHARE, learn, probabilities, weighted
from tools.train.picture.records import Box, Record
from tools.train.picture.samples import BACKGROUND, BURIED, CANDIDATE, DRAWN, SURFACE, PictureSamples

TRUTH = np.repeat(np.array((BURIED, SURFACE, SURFACE, BACKGROUND), np.int8), (40, 20, 200, 400))
BOX = np.repeat(np.array((0, 0, DRAWN, -1), np.int16), (40, 20, 200, 400))


def samples() -> PictureSamples:
    """Forty rows of buried mines, twenty of casings, 200 of drawn ones, and ground; noise that tells them apart."""
    count = len(TRUTH)
    vectors = np.random.default_rng(0).normal(0.0, 0.3, (count, LENGTH)).astype(np.float16)
    vectors[:, -1] += TRUTH
    what, picture = np.full(count, CANDIDATE, np.int8), np.zeros(count, np.int32)
    return PictureSamples(vectors, what, TRUTH, picture, BOX, np.ones(count, np.int8), np.zeros((count, 3), np.float32))


def test_drawn_casings_and_ground_count_for_their_share_however_many_there_are() -> None:
    mines, ground = np.nonzero(TRUTH != BACKGROUND)[0], np.nonzero(TRUTH == BACKGROUND)[0]
    _, labels, weights = weighted(samples(), mines, ground)
    box = BOX[np.concatenate((mines, ground))]
    buried, drawn, plain = weights[labels == BURIED].sum(), weights[box == DRAWN].sum(), labels == BACKGROUND
    casings = weights[(labels == SURFACE) & (box != DRAWN)].sum()
    assert casings == pytest.approx(SURFACE_SHARE * buried)
    assert drawn == pytest.approx(DRAWN_SHARE * (buried + casings))
    assert weights[plain].sum() == pytest.approx(GROUND_WEIGHT * weights[~plain].sum())


def test_averaged_weights_are_the_mean_of_the_last_steps() -> None:
    some = samples()
    learned = some.vectors, some.truth.astype(np.int64), np.ones(len(some))
    last, all_of_one, none = (fit(*learned, 1, 1, averaged=share) for share in (1e-6, 1.0, 0.0))
    assert np.allclose(all_of_one.weights[0], none.weights[0])
    assert np.array_equal(last.weights[0], none.weights[0])
    two, mean = fit(*learned, 2, 1, lambda _: 5e-4), fit(*learned, 2, 1, lambda _: 5e-4, averaged=1.0)
    one = fit(*learned, 1, 1, lambda _: 5e-4)
    assert np.allclose(mean.weights[0], 0.5 * (one.weights[0] + two.weights[0]), atol=1e-6)


def test_a_network_tells_apart_what_it_has_learned_the_same_each_time() -> None:
    some = samples()
    some.round[:] = 0
    one, again = (learn(some, np.ones(len(some), bool), 1).network for _ in range(2))
    p = probabilities(one, some.vectors)
    assert np.array_equal(p, probabilities(again, some.vectors))
    assert p.sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    background, mine = TRUTH == BACKGROUND, TRUTH == BURIED
    assert p[background, 2].mean() > 10.0 * p[mine, 2].mean()


@pytest.mark.parametrize("seed", range(12))
def test_boxes_stay_on_their_mines_from_another_height(seed: int) -> None:
    rows, columns = np.mgrid[0:400, 0:600] + 0.5
    box = Box(220.0, 150.0, 60.0, 60.0, "buried")
    picture = np.where(np.hypot(columns - box.x, rows - box.y) < 30.0, 200.0, 0.0).astype(np.float32)
    seen, (there,) = from_another_height(picture, (box,), np.random.default_rng(seed))
    v, u = np.nonzero(seen > 100.0)
    assert (u.mean() + 0.5, v.mean() + 0.5) == pytest.approx((there.x, there.y), abs=1.5)
    assert (np.ptp(u), np.ptp(v)) == pytest.approx((there.width, there.height), abs=4.0)
    assert MIN_ZOOM * 0.98 < there.side / box.side < MAX_ZOOM * 1.02


def record(zone: str, session: str) -> Record:
    return Record(f"{zone}{session}", zone, session, 2.0, (), np.zeros((4, 4), np.uint8))


def test_intervals_are_over_flights_however_many_pictures_they_have() -> None:
    records = [record(zone, session) for zone in "13" for session in "AB" for _ in range(50)]
    flight = flights(records)
    assert len(set(flight.tolist())) == 4
    found = np.repeat([1.0, 1.0, 0.0, 1.0], 50)
    value, low, high = rate(found, np.ones(200), flight)
    assert value == 0.75
    assert (low, high) == (0.25, 1.0), "four flights tell little, though each is 50 pictures"
    _, least, most = rate(found, np.ones(200), flight, others=True)
    assert least <= low < high < most, "four others may differ more"


def test_the_threshold_lets_the_stated_false_alarms_through_and_no_more() -> None:
    score, picture = np.array([0.9, 0.8, 0.3, 0.2]), np.array([0, 1, 1, 3])
    none = np.zeros(0)
    loud = Loudness(none, none.astype(int), score, picture, np.arange(4))
    for allowed in (0.25, 0.5, 0.75):
        threshold = loud.threshold_for(allowed)
        assert (score >= threshold).sum() == allowed * 4
    assert loud.threshold_for(2.0) == 0.0
