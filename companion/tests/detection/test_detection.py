"""From a frame to places: spots are found where they lie, described, classified, and fused over looks."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.detection.classifier import CLASSES, Classifier, default_model
from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.fusion import Evidence
from rover.detection.ground.candidates import MAX_CANDIDATES, find_candidates
from rover.detection.ground.detect import Detection, DetectSettings, detect, toned
from rover.detection.ground.image import GroundRectifier, from_picture
from rover.detection.ground.patch import LENGTH, SIDE, describe
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera

CAMERA = load_camera("lepton-160")
RECTIFIER = GroundRectifier(CAMERA)
COVARIANCE = np.diag([1e-4, 1e-4, 1e-4])


def frame(x: float = 0.6, y: float = 0.1, sigma: float = 0.04, contrast: float = 3.0) -> Frame:
    """Soil at 300 K with one soft spot on the ground at (x, y) of base_link, metres."""
    ground = CAMERA.ground_lookup
    noise = np.random.default_rng(3).normal(0, 0.05, ground.shape[:2])
    distance2 = (ground[..., 0] - x) ** 2 + (ground[..., 1] - y) ** 2
    kelvin = 300.0 + noise + contrast * np.exp(-0.5 * distance2 / sigma**2)
    return Frame(np.round(kelvin * 100).astype(np.uint16), 0.0, 0)


def found(label: str, x: float = 0.6, y: float = 0.0, sure: float = 0.85) -> Detection:
    p = {name: sure if name == label else (1.0 - sure) / 3 for name in CLASSES}
    return Detection(x, y, 0.12, p, (0, 0, 12, 12))


def looks(evidence: Evidence, count: int, *detections: Detection, step: float = 0.02) -> None:
    """Looks at the same ground by a rover that drives on: detections are given in map."""
    for index in range(count):
        pose = Pose2(index * step, 0.0, 0.0)
        local = [Detection(d.x - pose.x, d.y, d.extent, d.p, d.bbox) for d in detections]
        evidence.update(local, pose, COVARIANCE, 0.1 * index)


# -- ground image ------------------------------------------------------------------------------------------------


def test_ground_coordinates_and_pixels_are_inverse():
    image = RECTIFIER.rectify(frame())
    points = np.array([[0.5, 0.2], [0.9, -0.4]])
    assert image.to_base(image.to_pixel(points)) == pytest.approx(points)


def test_a_spot_lies_where_it_lies_on_the_ground():
    image = RECTIFIER.rectify(frame(0.7, -0.2))
    peak = np.unravel_index(np.where(image.valid, image.kelvin, 0).argmax(), image.kelvin.shape)
    assert image.to_base(np.array([peak], float))[0] == pytest.approx([0.7, -0.2], abs=0.02)


def test_a_frame_of_another_camera_is_one_clear_line():
    with pytest.raises(BadInput, match="320x240 pixels, but camera lepton-160 has 160x120"):
        RECTIFIER.rectify(Frame(np.zeros((240, 320), np.uint16), 0.0, 7))


def test_a_picture_is_resampled_to_one_centimetre():
    assert from_picture(np.ones((200, 100)), 0.005).kelvin.shape == (100, 50)


def test_coarse_pixels_are_not_multiplied_beyond_two_centimetres():
    assert from_picture(np.ones((200, 100)), 0.015).kelvin.shape == (200, 100)
    assert from_picture(np.ones((200, 100)), 0.04).metres_per_pixel == pytest.approx(0.02)


@pytest.mark.parametrize("metres_per_pixel", [0.005, 0.01, 0.02])
def test_a_spot_is_found_where_it_lies_whatever_the_pixels_are(metres_per_pixel):
    y, x = np.mgrid[0:240, 0:320] * metres_per_pixel
    middle = (0.55 * y.max(), 0.4 * x.max())
    image = from_picture(300.0 + np.exp(-((x - middle[1]) ** 2 + (y - middle[0]) ** 2) / 0.003), metres_per_pixel)
    strongest = find_candidates(image)[0]
    found_at = np.array([strongest.row + 0.5, strongest.column + 0.5]) * image.metres_per_pixel
    assert found_at == pytest.approx(np.array(middle) + 0.5 * metres_per_pixel, abs=0.005)


# -- candidates and patches --------------------------------------------------------------------------------------


@pytest.mark.parametrize("contrast", [2.0, -2.0, 0.5])
@pytest.mark.parametrize("sigma", [0.03, 0.05, 0.09])
def test_warm_and_cold_spots_of_all_sizes_are_found_within_2_cm(contrast, sigma):
    image = RECTIFIER.rectify(frame(0.65, 0.1, sigma, contrast))
    candidates = find_candidates(image)
    points = image.to_base(np.array([(c.row, c.column) for c in candidates]))
    nearest = np.hypot(*(points - (0.65, 0.1)).T)
    assert nearest.min() < 0.02
    assert np.sign(candidates[int(nearest.argmin())].answer) == np.sign(contrast)


def test_a_wide_weak_spot_is_not_lost_among_small_strong_ones():
    rng = np.random.default_rng(1)
    soil = cv2.GaussianBlur(rng.normal(0, 1, (93, 139)).astype(np.float32), (0, 0), 1.5)
    y, x = np.mgrid[0:93, 0:139]
    mine = 0.9 * np.exp(-0.5 * ((x - 70) ** 2 + (y - 45) ** 2) / 4.5**2)
    first = find_candidates(from_picture(300.0 + 0.35 * soil / soil.std() + mine, 0.01))[:3]
    assert min(np.hypot(c.row - 45, c.column - 70) for c in first) < 3


def test_candidates_are_capped():
    noise = np.random.default_rng(0).normal(300, 3, (100, 140)).astype(np.float32)
    assert len(find_candidates(from_picture(noise, 0.01))) == MAX_CANDIDATES


def test_plain_soil_of_an_even_temperature_has_no_candidates():
    assert find_candidates(from_picture(np.full((100, 140), 300.0), 0.01)) == []


def test_a_patch_says_contrast_in_kelvin_whatever_the_soil_is():
    def vector(soil: float) -> np.ndarray:
        y, x = np.mgrid[0:100, 0:140]
        spot = 3.0 * np.exp(-0.5 * ((x - 70) ** 2 + (y - 50) ** 2) / 16)
        image = from_picture(soil + spot, 0.01)
        features: np.ndarray = describe(image, find_candidates(image)[:1])[0]
        return features

    assert vector(280.0).shape == (LENGTH,)
    assert vector(280.0) == pytest.approx(vector(310.0), abs=1e-2)
    assert 1.0 < np.sinh(vector(280.0)[3 * SIDE * SIDE]) < 3.1


def test_rough_ground_is_toned_down_and_known_ground_is_left():
    noise = cv2.GaussianBlur(np.random.default_rng(4).normal(0, 1, (93, 139)).astype(np.float32), (0, 0), 3.0)
    even = from_picture(300.0 + 0.1 * noise, 0.01)
    assert toned(even, find_candidates(even)) is even
    rough = from_picture(300.0 + 10.0 * noise, 0.01)
    rougher = from_picture(300.0 + 20.0 * noise, 0.01)
    quiet, quieter = (toned(image, find_candidates(image)).kelvin for image in (rough, rougher))
    assert quiet.std() < 0.5 * rough.kelvin.std()
    assert quiet - np.median(quiet) == pytest.approx(quieter - np.median(quieter), abs=2e-3)


# -- classifier --------------------------------------------------------------------------------------------------


def test_the_shipped_model_gives_probabilities():
    classifier = Classifier(default_model())
    p = classifier.predict(np.zeros((3, LENGTH), np.float32))
    assert p.shape == (3, len(CLASSES))
    assert p.sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert len(classifier.sha256) == 64
    assert set(classifier.classes) == set(CLASSES)


def test_a_missing_or_broken_model_is_one_clear_line(tmp_path):
    with pytest.raises(BadInput, match=r"none\.onnx: the classifier cannot be read"):
        Classifier(tmp_path / "none.onnx")
    (tmp_path / "broken.onnx").write_bytes(b"no model")
    with pytest.raises(BadInput, match=r"broken\.onnx: not an ONNX model"):
        Classifier(tmp_path / "broken.onnx")


def test_detect_finds_a_warm_spot_and_takes_it_for_a_mine():
    image = RECTIFIER.rectify(frame(0.6, 0.1, 0.035, 4.0))
    detections = detect(image, Classifier(default_model()), DetectSettings())
    best = min(detections, key=lambda d: np.hypot(d.x - 0.6, d.y - 0.1))
    assert np.hypot(best.x - 0.6, best.y - 0.1) < 0.05
    assert best.p["surface"] + best.p["buried"] > 0.5


# -- fusion ------------------------------------------------------------------------------------------------------


def test_one_or_two_looks_are_no_suspicion_three_are_four_make_an_indication():
    states = []
    for count in (1, 2, 3, 4):
        evidence = Evidence(EvidenceSettings(report_threshold=0.5))
        looks(evidence, count, found("buried"))
        states.append((evidence.places[0].suspected, evidence.places[0].indication))
    assert states == [(False, False), (False, False), (True, False), (True, True)]


def test_looks_at_one_spot_are_one_place_that_keeps_its_number_and_gets_more_exact():
    evidence = Evidence(EvidenceSettings())
    looks(evidence, 2, found("surface"))
    (first,) = evidence.places
    before = first.sigma_m
    looks(evidence, 8, found("surface", 0.63, 0.02))
    (place,) = evidence.places
    assert (place.id, place.kind) == (first.id, "surface")
    assert place.sigma_m < before
    assert place.x == pytest.approx(0.62, abs=0.02)


def test_spots_half_a_metre_apart_are_two_places():
    evidence = Evidence(EvidenceSettings())
    looks(evidence, 4, found("surface", 0.5, 0.2), found("buried", 0.8, -0.2))
    assert [(p.kind, p.indication) for p in evidence.places] == [("surface", True), ("buried", True)]


def test_an_obstacle_is_no_place():
    evidence = Evidence(EvidenceSettings())
    looks(evidence, 6, found("obstacle"))
    assert not any(place.suspected for place in evidence.places)


def test_a_place_in_clear_view_that_is_not_found_again_is_dismissed():
    evidence = Evidence(EvidenceSettings())
    looks(evidence, 3, found("buried", 0.85, sure=0.6))
    assert evidence.places[0].suspected
    looks(evidence, 12, step=0.04)
    assert not any(place.suspected for place in evidence.places)


def test_a_place_out_of_view_keeps_its_probability():
    evidence = Evidence(EvidenceSettings())
    looks(evidence, 4, found("buried"))
    before = dict(evidence.places[0].p)
    for _ in range(20):
        evidence.update([], Pose2(3.0, 3.0, 0.0), COVARIANCE, 9.0)
    assert evidence.places[0].p == before


def test_frames_at_rest_weigh_less_than_frames_from_elsewhere():
    resting, driving = Evidence(EvidenceSettings()), Evidence(EvidenceSettings())
    looks(resting, 5, found("buried", 0.75, sure=0.55), step=0.0)
    looks(driving, 5, found("buried", 0.75, sure=0.55), step=0.08)
    assert driving.places[0].mine_probability > resting.places[0].mine_probability
