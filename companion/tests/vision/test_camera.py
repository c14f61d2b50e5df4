"""The camera model: equations 7 to 11 against worked values and against OpenCV, and files that say what is wrong."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.vision.camera.file import built_in_cameras, load_camera
from rover.vision.camera.model import CameraModel, focal_from_fov

LEPTON = load_camera("lepton-160")
BENT = dataclasses.replace(LEPTON, distortion=(-0.2, 0.05, 0.001, -0.002, 0.01), skew=1.5, yaw=0.2, roll=0.03)


def all_pixels(camera: CameraModel) -> np.ndarray:
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    return np.column_stack((u.ravel(), v.ravel())).astype(float)


def test_focal_length_of_the_papers_camera_by_equations_9_and_10() -> None:
    # 320 / (2 tan 22.5°) and 240 / (2 tan 17°): not the 0.16 that the paper prints.
    assert focal_from_fov(320, math.radians(45.0)) == pytest.approx(386.27, abs=0.01)
    assert focal_from_fov(240, math.radians(34.0)) == pytest.approx(392.50, abs=0.01)


def test_a_camera_made_from_its_angles_has_its_middle_between_the_middle_pixels() -> None:
    ideal = CameraModel.from_fov("c", 160, 120, math.radians(57.0))
    made = dataclasses.replace(ideal, z=0.75, pitch=math.radians(52.0))
    assert (made.cx, made.cy) == (79.5, 59.5)
    assert (made.fx, made.fy) == pytest.approx((LEPTON.fx, LEPTON.fx))
    np.testing.assert_allclose(made.matrix, [[made.fx, 0.0, 79.5], [0.0, made.fy, 59.5], [0.0, 0.0, 1.0]])  # equation 8


def test_the_middle_of_the_picture_looks_at_the_ground_where_the_pitch_says() -> None:
    ahead = LEPTON.pixel_to_ground(np.array([[79.5, 59.5]]))[0]
    assert ahead == pytest.approx([0.75 / math.tan(math.radians(52.0)), 0.0], abs=1e-9)


def test_left_on_the_ground_is_left_in_the_picture_and_far_is_up() -> None:
    left, right, far = LEPTON.ground_to_pixel(np.array([[0.6, 0.1], [0.6, -0.1], [1.0, 0.0]]))
    assert left[0] < 79.5 < right[0]
    assert far[1] < left[1]


@pytest.mark.parametrize("camera", [LEPTON, BENT, load_camera("e6390-320")], ids=lambda c: c.name)
def test_pixel_to_ground_and_back(camera: CameraModel) -> None:
    pixels = all_pixels(camera)
    np.testing.assert_allclose(camera.ground_to_pixel(camera.pixel_to_ground(pixels)), pixels, atol=1e-3)


@pytest.mark.parametrize("camera", [LEPTON, BENT], ids=["plain", "distorted"])
def test_projection_agrees_with_opencv(camera: CameraModel) -> None:
    ground = camera.pixel_to_ground(all_pixels(camera)[::97])
    turn, _ = cv2.Rodrigues(camera.extrinsic[:3, :3])
    points = np.column_stack((ground, np.zeros(len(ground))))
    plain = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    theirs, _ = cv2.projectPoints(
        points, turn, camera.extrinsic[:3, 3], plain, np.array(camera.distortion or [0.0] * 4)
    )
    theirs = theirs.reshape(-1, 2).astype(np.float64)
    theirs[:, 0] = theirs[:, 0] + camera.skew * (theirs[:, 1] - camera.cy) / camera.fy  # OpenCV's K knows no skew
    np.testing.assert_allclose(camera.ground_to_pixel(ground), theirs, atol=1e-6)


def test_above_the_horizon_there_is_no_ground() -> None:
    level = dataclasses.replace(LEPTON, pitch=0.0)
    ground = level.pixel_to_ground(np.array([[80.0, 10.0], [80.0, 119.0]]))
    assert np.isnan(ground[0]).all()
    assert np.isfinite(ground[1]).all()
    assert np.isnan(level.ground_to_pixel(np.array([[-1.0, 0.0]]))).all()


def test_the_lookup_holds_every_pixels_ground_point_and_cannot_be_changed() -> None:
    table = LEPTON.ground_lookup
    assert table.shape == (120, 160, 2)
    np.testing.assert_allclose(table[100, 30], LEPTON.pixel_to_ground(np.array([[30.0, 100.0]]))[0], rtol=1e-5)
    with pytest.raises(ValueError, match="read-only"):
        table[0, 0] = 0.0


def test_extrinsic_is_rigid_and_puts_the_mast_at_the_origin() -> None:
    e = BENT.extrinsic
    np.testing.assert_allclose(e[:3, :3] @ e[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(e[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(e @ [BENT.x, BENT.y, BENT.z, 1.0], [0.0, 0.0, 0.0, 1.0], atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(
    pitch=st.floats(0.6, 1.4),
    roll=st.floats(-0.2, 0.2),
    yaw=st.floats(-3.0, 3.0),
    height=st.floats(0.2, 2.0),
    u=st.floats(0.0, 159.0),
    v=st.floats(30.0, 119.0),
)
def test_back_and_forth_for_any_mount(pitch: float, roll: float, yaw: float, height: float, u: float, v: float) -> None:
    camera = dataclasses.replace(LEPTON, pitch=pitch, roll=roll, yaw=yaw, z=height)
    pixel = np.array([[u, v]])
    np.testing.assert_allclose(camera.ground_to_pixel(camera.pixel_to_ground(pixel)), pixel, atol=1e-6)


GOOD = 'name = "c"\nwidth = 160\nheight = 120\n[intrinsics]\nhfov_deg = 57.0\n[mount]\nz_m = 0.75\npitch_deg = 52.0\n'


def test_built_in_cameras_have_the_sizes_in_their_names() -> None:
    assert built_in_cameras() == ["e6390-320", "lepton-160"]
    assert [(load_camera(n).width, load_camera(n).height) for n in built_in_cameras()] == [(320, 240), (160, 120)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("width = 160", "width = 1.5"), "width: must be a whole number, not 1.5"),
        (("hfov_deg = 57.0", "hfov_deg = 190"), "hfov_deg: 190 lies outside 1 to 169.9 deg"),
        (("hfov_deg = 57.0", "hfov = 57"), r"\[intrinsics\] hfov: unknown key; did you mean hfov_deg\?"),
        (("hfov_deg = 57.0", "fx = 100.0"), r"\[intrinsics\] fy: missing"),
        (("hfov_deg = 57.0", "fx = 0.16\nfy = 0.16"), "fx: 0.16 lies outside 32 to 8000"),
        (("hfov_deg = 57.0", "hfov_deg = 57.0\nfx = 100.0"), "not both"),
        (("hfov_deg = 57.0", "hfov_deg = 57.0\ndistortion = [1.0]"), r"distortion: must be \[k1, k2"),
        (("z_m = 0.75", "z_m = -1"), "z_m: -1 lies outside 0.01 to 20 m"),
        (("z_m = 0.75", 'z_m = "high"'), "z_m: must be a number in m, not 'high'"),
        (("[mount]", "[mast]"), "mast: unknown key; known are name"),
        (('name = "c"', "name = "), "not valid TOML"),
    ],
)
def test_a_camera_file_that_is_wrong_says_where(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    file = tmp_path / "camera.toml"
    file.write_text(GOOD.replace(*change))
    with pytest.raises(BadInput, match=message) as caught:
        load_camera(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_camera_names_those_there_are() -> None:
    with pytest.raises(BadInput, match="e6390-320, lepton-160"):
        load_camera("boson")
