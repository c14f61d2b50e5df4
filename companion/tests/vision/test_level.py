"""A leaning rover's picture, put right: it shows the ground where a level rover's would."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.vision.camera.file import load_camera
from rover.vision.camera.level import levelled, roll_and_pitch

CAMERA = load_camera("lepton-160")


def up(roll: float, pitch: float) -> tuple[float, float, float]:
    return -math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)


def taken(roll: float, pitch: float) -> Frame:
    """Ground at 300 K + 5 K for each metre ahead + 3 K for each to the left, seen by a leaning rover: by hand."""
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    rotation = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width].astype(np.float64)
    rays = np.stack(((u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones_like(u)), axis=-1)
    rays = rays @ (rotation @ CAMERA.base_from_camera).T
    lens = rotation @ CAMERA.position
    reach = lens[2] / np.maximum(-rays[..., 2], 1e-3)
    x, y = lens[0] + reach * rays[..., 0], lens[1] + reach * rays[..., 1]
    kelvin = 300.0 + 5.0 * np.clip(x, -3.0, 3.0) + 3.0 * np.clip(y, -3.0, 3.0)
    return Frame(np.round(kelvin * 100.0).astype(np.uint16), 1.0, 1)


def off(frame: Frame) -> NDArray[np.float64]:
    """How far what is shown lies from where a level rover would see it, kelvin."""
    shown = np.ones(frame.counts.shape, bool) if frame.shown is None else frame.shown
    ground = CAMERA.ground_lookup
    near = shown & np.isfinite(ground).all(axis=-1) & (ground[..., 0] < 1.2)
    return np.abs(frame.counts / 100.0 - taken(0.0, 0.0).counts / 100.0)[near]


@pytest.mark.parametrize(("roll", "pitch"), [(0.035, 0.0), (0.0, 0.035), (0.0, -0.035), (-0.03, 0.02), (0.1, -0.1)])
def test_what_was_seen_leaning_lies_where_a_level_rover_sees_it(roll: float, pitch: float) -> None:
    leaning = taken(roll, pitch)
    right = levelled(leaning, CAMERA, up(roll, pitch))
    # 0.02 K are 4 mm of ground.
    assert off(right).max() < 0.05
    assert np.median(off(right)) < 0.01
    assert np.median(off(leaning)) > 5.0 * np.median(off(right)) + 0.02


def test_what_the_picture_does_not_hold_is_marked() -> None:
    right = levelled(taken(0.0, 0.05), CAMERA, up(0.0, 0.05))
    assert right.shown is not None
    assert 0.85 < right.shown.mean() < 1.0
    # Nose down shows nearer ground: of a level picture the far end is missing, at its upper edge.
    assert not right.shown[0].any()
    assert right.shown[-1, 5:-5].all()


def test_a_level_rovers_picture_is_left_as_it_is() -> None:
    frame = taken(0.0, 0.0)
    assert levelled(frame, CAMERA, (0.001, 0.0, 9.81)) is frame


def test_roll_is_left_side_up_and_pitch_nose_down() -> None:
    assert roll_and_pitch(up(0.1, -0.2)) == pytest.approx((0.1, -0.2))
