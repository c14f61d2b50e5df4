"""Specification: pictures without kelvin are searched at every size, and a picture that shows nothing has a name."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.detection.classifier import PICTURES, Classifier, default_model
from rover.detection.model_file import shipped
from rover.detection.picture.candidates import find_spots
from rover.detection.picture.check import check_picture
from rover.detection.picture.detect import MAX_DETECTIONS, SAME, detect_in_picture, thin
from rover.detection.picture.features import CHANNELS, Features, cells_of, shipped_features
from rover.detection.picture.maps import picture_maps
from rover.detection.picture.occupancy import SIDE, WIDTH, occupancy
from rover.detection.picture.patch import LENGTH, describe_spots
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


def test_every_spot_has_one_vector() -> None:
    maps = picture_maps(turf())
    spots = find_spots(maps)
    vectors = describe_spots(maps, spots, shipped_features())
    assert vectors.shape == (len(spots), LENGTH)
    assert np.isfinite(vectors).all()
    assert describe_spots(maps, spots[:0], shipped_features()).shape == (0, LENGTH)


def test_a_spot_is_described_the_same_whatever_else_is_asked_about() -> None:
    maps = picture_maps(with_disc(330, 300, 80, 220.0))
    spots = find_spots(maps)
    every, one = (describe_spots(maps, some, shipped_features()) for some in (spots, spots[5:6]))
    assert one[0] == pytest.approx(every[5], abs=1e-3)


def test_a_gain_of_the_camera_hardly_changes_the_description() -> None:
    picture = with_disc(330, 300, 80, 220.0)
    spots = np.array([[330.0, 300.0, 80.0], [100.0, 100.0, 80.0]], np.float32)
    dimmed = np.asarray(0.7 * picture + 20.0, np.float32)
    bright, dim = (describe_spots(picture_maps(p), spots, shipped_features()) for p in (picture, dimmed))
    assert np.abs(bright - dim).mean() < 0.1 * np.abs(bright[0] - bright[1]).mean()


@pytest.mark.parametrize("size", [32, 120, 321, 640])
def test_features_are_means_over_cells_that_lie_on_the_picture(size: int) -> None:
    rows, columns = cells_of((size, size))
    grey = np.random.default_rng(2).normal(0.0, 0.5, (size, size)).astype(np.float32)
    each = shipped_features().seen(grey, np.eye(rows * columns, dtype=np.float32))
    mean = shipped_features().seen(grey, np.full((1, rows * columns), 1.0 / (rows * columns), np.float32))
    assert each.shape == (rows * columns, CHANNELS)
    assert mean[0] == pytest.approx(each.mean(axis=0), abs=1e-3)


def test_features_show_what_lies_at_a_spot_and_not_elsewhere() -> None:
    plain, marked = (picture_maps(p) for p in (turf(), with_disc(480, 160, 60, 235.0)))
    spots = np.array([[480.0, 160.0, 60.0], [100.0, 560.0, 60.0]], np.float32)
    finest = slice(0, 2 * CHANNELS)
    there, elsewhere = np.abs(shipped_features().describe(plain, spots) - shipped_features().describe(marked, spots))[
        :, finest
    ].mean(axis=1)
    assert there > 4.0 * elsewhere


def test_features_that_are_not_those_of_the_training_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    classifier = Classifier(default_model(PICTURES), PICTURES)
    monkeypatch.setattr(classifier, "features_sha256", "0" * 64)
    with pytest.raises(BadInput, match=r"landmine_pictures\.onnx: trained with other features; train one"):
        detect_in_picture(turf(), classifier)


def test_spoiled_features_are_noticed_by_their_hash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spoiled = tmp_path / "picture_features.onnx"
    spoiled.write_bytes(shipped(spoiled.name).read_bytes()[:-1] + b"x")
    spoiled.with_suffix(".sha256").write_text(shipped(spoiled.name).with_suffix(".sha256").read_text())
    monkeypatch.setattr("rover.detection.picture.features.shipped", lambda name: tmp_path / name)
    with pytest.raises(BadInput, match=r"picture_features\.onnx: its SHA-256 is"):
        Features()


def test_occupied_cells_are_those_of_the_disc() -> None:
    spots = np.array([[330.0, 300.0, 80.0]], np.float32)
    cells = occupancy(picture_maps(with_disc(330, 300, 80, 235.0)), spots).reshape(SIDE, SIDE)
    middles = (np.arange(SIDE) - (SIDE - 1) / 2) * WIDTH / SIDE
    away = np.hypot(*np.meshgrid(middles, middles))
    assert cells[away < 0.4].all()
    assert not cells[away > 0.6].any()


@pytest.mark.parametrize(("across", "down"), [(1, -1), (-1, 1), (-1, -1)])
def test_a_mirrored_picture_is_occupied_in_mirrored_cells(across: int, down: int) -> None:
    picture = with_disc(330, 300, 80, 235.0)
    there = np.array([[340.0 if across > 0 else 300.0, 310.0 if down > 0 else 330.0, 90.0]], np.float32)
    plain = occupancy(picture_maps(picture), np.array([[340.0, 310.0, 90.0]], np.float32)).reshape(SIDE, SIDE)
    mirrored = occupancy(picture_maps(np.ascontiguousarray(picture[::down, ::across])), there).reshape(SIDE, SIDE)
    assert (mirrored == plain[::down, ::across]).mean() > 0.95


@pytest.mark.parametrize(("across", "down"), [(1, -1), (-1, 1), (-1, -1)])
def test_a_casing_is_found_in_mirror_images_too(across: int, down: int) -> None:
    classifier = Classifier(default_model(PICTURES), PICTURES)
    for side in (1, 2):
        picture = with_disc(330, 240, 90, 235.0)[::down, ::across]
        picture = cv2.resize(picture, None, fx=1 / side, fy=1 / side, interpolation=cv2.INTER_AREA)
        best = detect_in_picture(np.ascontiguousarray(picture, np.float32), classifier)[0]
        x, y = (330 if across > 0 else 310) / side, (240 if down > 0 else 400) / side
        assert np.hypot(best.x - x, best.y - y) < 20 / side
        assert best.mine_probability >= classifier.threshold


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
