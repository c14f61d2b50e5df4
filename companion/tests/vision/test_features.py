"""Preprocessing, features, clustering and matching: each step does what the next one relies on."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.vision.registration.cluster import dbscan
from rover.vision.registration.features import FeatureDetector, Features, FeatureSettings, spread
from rover.vision.registration.matching import (
    MatchSettings,
    hamming,
    hamming_by_product,
    match_both_ways,
    match_features,
    mutual_matches,
    signs,
)
from rover.vision.registration.preprocess import Preprocessor, PreprocessSettings, remove_stripes, repair_dead_pixels

from companion.tests.vision.thermal_scene import texture


def smooth_scene(seed: int = 1) -> np.ndarray:
    return (texture(np.random.default_rng(seed))[400:520, 400:560] * 100.0).astype(np.float32)


def test_stripes_are_taken_off_and_the_scene_stays() -> None:
    rng = np.random.default_rng(3)
    scene = smooth_scene()
    striped = (
        scene + rng.normal(0.0, 30.0, (1, 160)).astype(np.float32) + rng.normal(0.0, 30.0, (120, 1)).astype(np.float32)
    )
    before = np.std(striped - scene)
    after = np.std(remove_stripes(striped) - scene)
    untouched = np.std(remove_stripes(scene) - scene)
    assert before > 40.0
    assert after < 0.45 * before
    assert untouched < 0.25 * np.std(scene)


def test_dead_pixels_are_filled_from_their_neighbours_and_no_others() -> None:
    scene = smooth_scene()
    damaged = scene.copy()
    damaged[50, 60], damaged[80, 20] = 0.0, 65535.0
    repaired = repair_dead_pixels(damaged)
    assert np.abs(repaired - scene).max() < 40.0
    assert np.count_nonzero(repaired != damaged) <= 2 + 0.01 * scene.size


def test_contrast_limits_follow_slowly() -> None:
    prepare = Preprocessor(PreprocessSettings(hold=0.8))
    scene = smooth_scene().astype(np.uint16)
    prepare(scene)
    first = prepare.limits
    hot = scene.copy()
    hot[:40] += 2000
    prepare(hot)
    assert first is not None
    assert prepare.limits is not None
    assert 200.0 < prepare.limits[1] - first[1] < 600.0
    prepare.forget()
    prepare(hot)
    assert prepare.limits[1] - first[1] > 1800.0


def test_a_flat_picture_is_black_and_without_features() -> None:
    picture = Preprocessor()(np.full((120, 160), 30000, np.uint16))
    assert len(FeatureDetector().detect(picture)) == 0


def test_the_cells_of_the_picture_take_turns_although_one_corner_is_far_stronger() -> None:
    rng = np.random.default_rng(0)
    weak = [cv2.KeyPoint(x, y, 7, 0, 1.0) for x, y in rng.uniform((0, 0), (160, 120), (300, 2)).tolist()]
    strong = [cv2.KeyPoint(x, y, 7, 0, 100.0) for x, y in rng.uniform((0, 0), (80, 60), (300, 2)).tolist()]
    chosen = spread((*weak, *strong), 160, 120, FeatureSettings(count=100))
    points = np.array([(*weak, *strong)[i].pt for i in chosen])
    inside = np.mean((points[:, 0] < 80) & (points[:, 1] < 60))
    assert len(chosen) == len(set(chosen.tolist())) == 100
    assert inside < 0.4


def test_never_more_features_than_asked() -> None:
    picture = np.random.default_rng(0).integers(0, 255, (120, 160)).astype(np.uint8)
    assert len(FeatureDetector(FeatureSettings(count=100)).detect(picture)) == 100


def test_the_threshold_comes_down_for_a_faint_picture_and_up_for_a_rich_one() -> None:
    rng = np.random.default_rng(0)
    detector = FeatureDetector(FeatureSettings(count=200))
    start = detector.threshold
    detector.detect((rng.integers(0, 6, (120, 160)) + 100).astype(np.uint8))
    assert detector.threshold < start
    for _ in range(20):
        detector.detect(rng.integers(0, 255, (120, 160)).astype(np.uint8))
    assert detector.threshold > start


def test_same_picture_same_features() -> None:
    picture = np.random.default_rng(5).integers(0, 255, (120, 160)).astype(np.uint8)
    a, b = (FeatureDetector().detect(picture) for _ in range(2))
    np.testing.assert_array_equal(a.points, b.points)
    np.testing.assert_array_equal(a.descriptors, b.descriptors)


def test_hamming_distances_are_exact() -> None:
    rng = np.random.default_rng(2)
    a, b = rng.integers(0, 256, (17, 32), dtype=np.uint8), rng.integers(0, 256, (23, 32), dtype=np.uint8)
    expected = np.unpackbits(a[:, None] ^ b[None], axis=2).sum(axis=2)
    np.testing.assert_array_equal(hamming(a, b), expected)
    np.testing.assert_array_equal(hamming_by_product(signs(a), signs(b)), expected)


def test_matches_are_mutual_distinct_and_allowed() -> None:
    distances = np.array([[10, 90, 90], [12, 80, 90], [90, 90, 30], [90, 40, 41]], np.float32)
    rows, columns = mutual_matches(distances, None, MatchSettings(max_distance=72, ratio=0.9))
    # Row 1 prefers a column that prefers row 0; row 3's two candidates are too alike.
    assert list(zip(rows, columns, strict=True)) == [(0, 0), (2, 2)]
    allowed = np.ones_like(distances, bool)
    allowed[0, 0] = False
    rows, columns = mutual_matches(distances, allowed, MatchSettings(max_distance=72, ratio=0.9))
    assert (1, 0) in list(zip(rows, columns, strict=True))


def test_both_ways_from_the_same_distances_match_as_each_way_alone() -> None:
    rng = np.random.default_rng(6)
    seen = rng.integers(0, 256, (60, 32), dtype=np.uint8)
    again = np.concatenate((seen[10:50], seen[12:20] ^ np.uint8(1), rng.integers(0, 256, (30, 32), dtype=np.uint8)))
    a, b = (Features(np.zeros((len(d), 2)), d, np.ones(len(d))) for d in (seen, again))
    ways = match_both_ways(hamming(a.descriptors, b.descriptors), MatchSettings(ratio=0.85))
    alone = match_features(a, b, MatchSettings(ratio=0.85)), match_features(b, a, MatchSettings(ratio=0.85))
    for (in_one, in_other), expected in zip(ways, alone, strict=True):
        np.testing.assert_array_equal((in_one, in_other), expected)
    assert len(ways[0][0]) >= 30


def test_nothing_matches_nothing() -> None:
    rows, columns = mutual_matches(np.empty((0, 5), np.float32), None, MatchSettings())
    assert len(rows) == len(columns) == 0


def test_dbscan_finds_two_groups_and_calls_the_rest_noise() -> None:
    rng = np.random.default_rng(1)
    points = np.vstack((rng.normal(0, 5, (20, 2)), rng.normal(200, 5, (15, 2)), [[100.0, 100.0], [400.0, 0.0]]))
    labels = dbscan(points)
    assert set(labels[:20]) == {0}
    assert set(labels[20:35]) == {1}
    assert list(labels[35:]) == [-1, -1]


def test_dbscan_of_nothing_and_of_too_few() -> None:
    assert len(dbscan(np.empty((0, 2)))) == 0
    assert list(dbscan(np.zeros((4, 2)))) == [-1] * 4
    assert list(dbscan(np.zeros((5, 2)))) == [0] * 5


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), count=st.integers(1, 120), spread=st.floats(20.0, 400.0), least=st.integers(2, 8)
)
def test_dbscan_agrees_with_scikit_learn(seed: int, count: int, spread: float, least: int) -> None:
    reference = pytest.importorskip("sklearn.cluster", reason="scikit-learn is the reference for this test only")
    points = np.random.default_rng(seed).uniform(0.0, spread, (count, 2)).round(1)
    expected = reference.DBSCAN(eps=20.0, min_samples=least).fit_predict(points)
    np.testing.assert_array_equal(dbscan(points, 20.0, least), expected)
