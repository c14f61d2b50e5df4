"""A homography that is nearly right becomes right; one that cannot be improved stays as it was."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.refine import RefineSettings, fit_homography, refine_homography

from companion.tests.vision.thermal_scene import texture

TRUTH = np.array([[0.9, -0.2, 60.0], [0.15, 1.0, -30.0], [1e-4, -5e-5, 1.0]])
CORNERS = np.array([[0.0, 0.0], [800.0, 0.0], [800.0, 640.0], [0.0, 640.0]])


def pictures() -> tuple[np.ndarray, np.ndarray]:
    ground = texture(np.random.default_rng(1))[200:840, 200:1000]
    first = np.clip((ground - 299.0) * 127.0, 0, 255).astype(np.uint8)
    second = cv2.warpPerspective(first, TRUTH, (800, 640))
    noise = np.random.default_rng(2).normal(0.0, 3.0, second.shape)
    return first, np.clip(second + noise, 0, 255).astype(np.uint8)


def corner_error(homography: np.ndarray) -> float:
    return float(np.linalg.norm(apply_homography(homography, CORNERS) - apply_homography(TRUTH, CORNERS), axis=1).max())


def test_two_pixels_off_become_a_fraction_of_one() -> None:
    first, second = pictures()
    start = np.array([[1.002, 0.001, 1.5], [-0.001, 0.999, -1.0], [0.0, 0.0, 1.0]]) @ TRUTH
    assert corner_error(start) > 1.5
    assert corner_error(refine_homography(first, second, start, RefineSettings())) < 0.15


def test_pictures_without_texture_change_nothing() -> None:
    flat = np.full((120, 160), 90, np.uint8)
    np.testing.assert_array_equal(refine_homography(flat, flat, np.eye(3), RefineSettings()), np.eye(3))


def test_pictures_that_have_nothing_in_common_change_nothing_or_little() -> None:
    first, _ = pictures()
    other = np.random.default_rng(3).integers(0, 255, first.shape).astype(np.uint8)
    np.testing.assert_array_equal(refine_homography(first, other, TRUTH, RefineSettings()), TRUTH)


@pytest.mark.parametrize("seed", range(5))
def test_a_third_of_wrong_points_does_not_pull_the_fit(seed: int) -> None:
    random = np.random.default_rng(seed)
    near_identity = np.eye(3) + random.normal(0, 1, (3, 3)) * [[5e-3, 5e-3, 2], [5e-3, 5e-3, 2], [1e-5, 1e-5, 0]]
    start = random.uniform(0, 600, (300, 2))
    end = apply_homography(near_identity, start) + random.normal(0, 0.1, (300, 2))
    end[:100] += random.uniform(-15, 15, (100, 2))
    fitted = fit_homography(start, end, 0.5)
    assert fitted is not None
    assert np.abs(apply_homography(fitted, start) - apply_homography(near_identity, start)).max() < 0.15


def test_points_on_a_line_do_not_determine_a_homography() -> None:
    line = np.column_stack((np.arange(50.0), np.arange(50.0)))
    fitted = fit_homography(line, line, 0.5)
    assert fitted is None or np.abs(apply_homography(fitted, line) - line).max() < 1e-6
