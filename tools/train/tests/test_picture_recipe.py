"""Specification: what counts how much when the network for pictures learns, and which weights it keeps."""

from __future__ import annotations

import numpy as np
import pytest
from rover.detection.picture_patch import LENGTH

from tools.train.network import fit
from tools.train.picture_recipe import DRAWN_SHARE, GROUND_WEIGHT, SURFACE_SHARE, mirrored_logits, weighted
from tools.train.picture_samples import BACKGROUND, BURIED, CANDIDATE, DRAWN, SURFACE, PictureSamples

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
