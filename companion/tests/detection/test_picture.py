"""Specification: pictures without kelvin are searched at every size, and a picture that shows nothing has a name."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from rover.detection.classifier import PICTURES, Classifier, default_model
from rover.detection.picture import circles
from rover.detection.picture.candidates import find_spots
from rover.detection.picture.check import check_picture
from rover.detection.picture.detect import MAX_DETECTIONS, SAME, detect_in_picture, judge, thin
from rover.detection.picture.maps import picture_maps
from rover.detection.picture.patch import LENGTH, MIRRORED, describe_spots
from rover.errors import BadInput


def turf(size: int = 640, seed: int = 1) -> np.ndarray:
    """Grey levels of rough ground."""
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (size, size)).astype(np.float32)
    return np.clip(120.0 + 18.0 * noise + 40.0 * cv2.GaussianBlur(noise, (0, 0), 6.0), 0, 255)


def with_disc(x: float, y: float, diameter: float, grey: float) -> np.ndarray:
    """Turf with one even disc."""
    picture = turf()
    rows, columns = np.mgrid[0:640, 0:640]
    picture[np.hypot(columns - x, rows - y) < diameter / 2] = grey
    return picture


@pytest.mark.parametrize("diameter", [24, 60, 150, 340])
@pytest.mark.parametrize("grey", [40.0, 230.0])
def test_warm_and_cold_discs_of_every_size_are_candidates(diameter: float, grey: float) -> None:
    spots = find_spots(picture_maps(with_disc(330, 300, diameter, grey)))
    near = np.hypot(spots[:, 0] - 330, spots[:, 1] - 300) < 0.25 * diameter
    fits = np.abs(np.log(spots[:, 2] / diameter)) < np.log(1.6)
    assert (near & fits).any()


def test_a_spot_of_the_ground_s_own_grey_is_found_by_its_smoothness() -> None:
    spots = find_spots(picture_maps(with_disc(330, 300, 110, 120.0)))
    near = (np.hypot(spots[:, 0] - 330, spots[:, 1] - 300) < 30) & (spots[:, 2] > 50) & (spots[:, 2] < 200)
    assert near.any()


@pytest.mark.parametrize("size", [640, 320, 500])
def test_every_level_shows_a_spot_at_the_same_place(size: int) -> None:
    rows, columns = np.mgrid[0:size, 0:size] + 0.5
    x, y = 0.55 * size, 0.4 * size
    picture = 40.0 + 200.0 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * (0.08 * size) ** 2))
    maps = picture_maps(picture.astype(np.float32))
    for number, level in enumerate(maps.levels[0][:4]):
        weight = np.maximum(level - 60.0, 0.0)
        v, u = np.mgrid[0 : level.shape[0], 0 : level.shape[1]]
        middle = ((weight * u).sum() / weight.sum(), (weight * v).sum() / weight.sum())
        assert [maps.from_level(float(m), number) for m in middle] == pytest.approx([x, y], abs=0.5)
        assert maps.to_level(np.float32(x), number) == pytest.approx(middle[0], abs=0.2)


def test_a_scale_rules_out_what_no_mine_measures() -> None:
    maps = picture_maps(turf())
    sizes = find_spots(maps, 0.01)[:, 2] * 0.01
    assert sizes.min() > 0.04
    assert sizes.max() < 1.6
    assert find_spots(maps)[:, 2].max() * 0.01 > 2.0


def test_numbers_of_circles_do_not_change_when_the_picture_is_turned() -> None:
    picture = with_disc(330, 300, 80, 220.0)
    turned = np.ascontiguousarray(np.rot90(picture))
    spot, as_turned = np.array([[330.0, 300.0, 80.0]], np.float32), np.array([[300.0, 310.0, 80.0]], np.float32)
    first, _ = circles.describe(picture_maps(picture), spot)
    second, _ = circles.describe(picture_maps(turned), as_turned)
    assert first.shape == (1, circles.NUMBERS)
    assert np.abs(first - second).mean() < 0.08
    assert np.quantile(np.abs(first - second), 0.95) < 0.4


@pytest.mark.parametrize(("number", "across", "down"), [(1, 1, -1), (2, -1, 1), (3, -1, -1)])
def test_a_mirrored_vector_is_that_of_the_mirrored_picture(number: int, across: int, down: int) -> None:
    picture = with_disc(330, 300, 80, 220.0)
    spot = np.array([[340.0, 310.0, 90.0]], np.float32)
    there = np.array([[340.0 if across > 0 else 300.0, 310.0 if down > 0 else 330.0, 90.0]], np.float32)
    plain = describe_spots(picture_maps(picture), spot)[0]
    mirrored = describe_spots(picture_maps(np.ascontiguousarray(picture[::down, ::across])), there)[0]
    assert sorted(MIRRORED[number].tolist()) == list(range(LENGTH))
    assert np.abs(mirrored - plain[MIRRORED[number]]).mean() < 0.3 * np.abs(mirrored - plain).mean()


def test_mirror_images_of_a_candidate_are_judged_alike() -> None:
    classifier = Classifier(default_model(PICTURES), PICTURES)
    vectors = describe_spots(picture_maps(with_disc(330, 300, 80, 220.0)), np.array([[330, 300, 80]], np.float32))
    assert (classifier.predict(vectors)[:, 1:3].sum(axis=1) > 0.05).all()
    answers = [judge(vectors[:, image], classifier) for image in MIRRORED]
    assert np.ptp(answers, axis=0).max() < 1e-5


def test_every_spot_has_one_vector() -> None:
    maps = picture_maps(turf())
    spots = find_spots(maps)
    vectors = describe_spots(maps, spots)
    assert vectors.shape == (len(spots), LENGTH)
    assert np.isfinite(vectors).all()
    assert describe_spots(maps, spots[:0]).shape == (0, LENGTH)


def test_a_spot_ranks_the_same_beside_the_others_whether_it_is_one_of_them_or_not() -> None:
    maps = picture_maps(with_disc(330, 300, 80, 220.0))
    spots = find_spots(maps)
    assert describe_spots(maps, spots[5:6], spots) == pytest.approx(describe_spots(maps, spots)[5:6], abs=1e-3)


def test_a_gain_of_the_camera_hardly_changes_the_description() -> None:
    picture = with_disc(330, 300, 80, 220.0)
    spot = np.array([[330.0, 300.0, 80.0]], np.float32)
    bright = describe_spots(picture_maps(picture), spot)
    dim = describe_spots(picture_maps((0.7 * picture + 20.0).astype(np.float32)), spot)
    assert np.abs(bright - dim)[0].mean() < 0.05


def test_of_spots_at_one_place_the_likeliest_stays() -> None:
    spots = np.array([[100, 100, 40], [104, 98, 48], [300, 300, 40]], np.float32)
    assert thin(spots, np.array([0.2, 0.9, 0.5]), MAX_DETECTIONS) == [1, 2]
    assert SAME < 1.0


def test_detections_are_likeliest_first_and_probabilities_sum_to_one() -> None:
    found = detect_in_picture(with_disc(330, 300, 60, 235.0), Classifier(default_model(PICTURES), PICTURES))
    scores = [d.mine_probability for d in found]
    assert scores == sorted(scores, reverse=True)
    assert 0 < len(found) <= MAX_DETECTIONS
    assert sum(found[0].p.values()) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(
    ("picture", "name"),
    [
        (np.full((240, 320), 90, np.uint8), "blank"),
        (np.full((240, 320), 30_000, np.uint16), "blank"),
        (np.full((240, 320), 255, np.uint8), "saturated"),
        (np.where(np.arange(320) < 200, 65_535, 30_000).astype(np.uint16) * np.ones((240, 1), np.uint16), "saturated"),
        (turf(320).astype(np.uint8).astype(np.uint16), "8-bit values in a 16-bit file"),
        (turf(16).astype(np.uint8), "wrong size: 16x16"),
    ],
)
def test_a_picture_that_shows_nothing_is_named(picture: np.ndarray, name: str) -> None:
    with pytest.raises(BadInput, match=rf"p\.png: {name}"):
        check_picture(picture, "p.png")


def test_eight_bits_where_sixteen_were_promised_and_another_size_are_named() -> None:
    with pytest.raises(BadInput, match="8-bit picture where 16 bits"):
        check_picture(turf(320).astype(np.uint8), "p.png", radiometric=True)
    with pytest.raises(BadInput, match="wrong size: 320x320 pixels, 160x120 expected"):
        check_picture(turf(320).astype(np.uint8), "p.png", (160, 120))


def test_a_sound_picture_is_let_through() -> None:
    check_picture(turf(320).astype(np.uint8), "p.png", (320, 320))
    check_picture((30_000 + turf(320)).astype(np.uint16), "p.png", radiometric=True)
