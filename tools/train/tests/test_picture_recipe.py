"""Specification: what counts how much when the network for pictures learns, and which weights it keeps."""

from __future__ import annotations

import numpy as np
import pytest
from rover.detection.picture.patch import LENGTH

from tools.train.network import fit
from tools.train.picture.recipe import (
    DRAWN_SHARE,
    GROUND_WEIGHT,
    SURFACE_SHARE,
    mirrored_logits,
    mirrored_mean,
    weighted,
)
from tools.train.picture.samples import BACKGROUND, BURIED, CANDIDATE, DRAWN, MINE_UNKNOWN, SURFACE, PictureSamples
from tools.train.picture.taught import both, network_says, taught

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


def test_every_mirror_image_is_asked() -> None:
    some = samples()
    network = fit(some.vectors, some.truth.astype(np.int64), np.ones(len(some)), 1, 1)
    answers = mirrored_logits(network, some.vectors)
    assert answers.shape == (4, len(some), 3)
    assert np.allclose(answers[0], network.logits(some.vectors)[:, SURFACE:])
    assert not np.allclose(answers[1], answers[0])


def test_a_label_counts_for_half_and_the_answers_for_the_rest() -> None:
    truth = np.array((BURIED, MINE_UNKNOWN, BACKGROUND, BACKGROUND))
    told = np.array((0, 1, 1, 2)), np.array((BURIED, SURFACE, BURIED, BACKGROUND)), np.array((2.0, 0.5, 0.5, 3.0))
    said = np.array(((0.2, 0.6, 0.2), (0.6, 0.2, 0.2), (0.01, 0.01, 0.98), (0.0, 0.4, 0.6)))
    rows, labels, weights = taught(told, truth, np.arange(4), said)
    learned = np.zeros((4, 3))
    np.add.at(learned, (rows, labels - SURFACE), weights)
    assert learned[0] == pytest.approx([0.2, 1.6, 0.2])
    assert learned[1] == pytest.approx([0.675, 0.225, 0.1]), "a mine of unknown kind is of the kinds that are said"
    assert learned[2] == pytest.approx([0.0, 0.0, 3.0]), "what is hardly likely is not learned"
    assert learned[3] == pytest.approx([0.0, 1.2, 1.8]), "without a label: as ground counts, by the answers alone"


@pytest.mark.slow
def test_the_second_opinion_is_half_the_networks_and_the_same_each_time() -> None:
    some = samples()
    some.round[:] = 0
    network = fit(some.vectors, some.truth.astype(np.int64), np.ones(len(some)), 3, 1)
    rows = np.arange(0, len(some), 3)
    alone = network_says(network, some, rows)
    assert alone == pytest.approx(mirrored_mean(mirrored_logits(network, some.vectors[rows])), abs=1e-4)
    one, again = (both(network, some, np.arange(len(some)), rows, 1) for _ in range(2))
    assert np.array_equal(one, again)
    assert one.sum(axis=1) == pytest.approx(1.0)
    assert ((one >= 0.5 * alone - 1e-5) & (one <= 0.5 * alone + 0.5 + 1e-5)).all()
