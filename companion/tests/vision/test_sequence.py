"""A camera's way is found from its frames alone: on a synthetic scene with depth, and on a real façade."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.capture.picture import read_picture
from rover.vision.camera.model import CameraModel
from rover.vision.camera.pose import CameraPose
from rover.vision.tracking.bundle import Scene, adjust
from rover.vision.tracking.sequence import SequenceSettings, track_sequence

from companion.tests.vision.thermal_scene import texture

CAMERA = CameraModel("synthetic", 320, 240, 300.0, 300.0, 159.5, 119.5)


def angle_deg(rotation: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))))


def between_deg(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1, 1))))


def relative(a: CameraPose, b: CameraPose) -> tuple[np.ndarray, np.ndarray]:
    return a.rotation.T @ b.rotation, a.rotation.T @ (b.position - a.position)


def slanted_wall(frames: int) -> tuple[list[np.ndarray], list[tuple[np.ndarray, np.ndarray]]]:
    """Pictures of a textured wall, 2 m away and seen at a slant, while the camera moves aside and turns; its poses."""
    wall = texture(np.random.default_rng(4))[:1200, :1600].astype(np.float32)
    metre = 200.0  # pixels of the texture
    face = cv2.Rodrigues(np.array([0.25, 0.3, 0.0]))[0]
    corner = face @ np.array([-4.0, -3.0, 0.0]) + [0.0, 0.0, 2.0]
    onto = np.column_stack((face[:, 0] / metre, face[:, 1] / metre, corner))
    pictures, poses = [], []
    noise = np.random.default_rng(5)
    for step in range(frames):
        rotation = cv2.Rodrigues(np.array([0.01, -0.02, 0.015]) * step)[0]
        position = np.array([0.08, 0.02, 0.01]) * step
        view = CAMERA.matrix @ rotation.T @ (onto - np.outer(position, [0, 0, 1]))
        picture = cv2.warpPerspective(wall, view, (320, 240)) + noise.normal(0, 0.02, (240, 320))
        pictures.append(np.clip(picture * 100, 0, 65535).astype(np.uint16))
        poses.append((rotation, position))
    return pictures, poses


@pytest.mark.slow
def test_a_synthetic_way_past_a_slanted_wall() -> None:
    pictures, truth = slanted_wall(6)
    found = track_sequence(pictures, CAMERA, SequenceSettings())
    assert [pose.frame for pose in found] == list(range(6))
    for a, b in pairwise(found):
        (turn_a, at_a), (turn_b, at_b) = truth[a.frame], truth[b.frame]
        turn, shift = relative(a, b)
        assert angle_deg(turn.T @ turn_a.T @ turn_b) < 0.3
        assert between_deg(shift, turn_a.T @ (at_b - at_a)) < 4.0


@pytest.mark.slow
def test_a_frame_of_something_else_is_left_out() -> None:
    pictures, _ = slanted_wall(5)
    pictures[2] = np.random.default_rng(1).integers(29000, 30000, (240, 320)).astype(np.uint16)
    found = track_sequence(pictures, CAMERA, SequenceSettings())
    assert [pose.frame for pose in found] == [0, 1, 3, 4]


def test_pictures_that_show_nothing_give_no_poses() -> None:
    assert track_sequence([np.full((240, 320), 30000, np.uint16)] * 3, CAMERA, SequenceSettings()) == []


def test_adjustment_finds_the_scene_that_the_observations_came_from() -> None:
    random = np.random.default_rng(7)
    turns = np.stack([cv2.Rodrigues(random.normal(0, 0.05, 3) * index)[0] for index in range(4)])
    shifts = random.normal(0, 0.2, (4, 3)) * np.arange(4)[:, None]
    points = random.uniform([-1, -1, 3], [1, 1, 5], (60, 3))
    frame, point = np.repeat(np.arange(4), 60), np.tile(np.arange(60), 4)
    exact = Scene(turns.astype(np.float64), shifts, points, frame, point, np.zeros((240, 2)))
    exact.seen = -exact.residuals()
    blurred = np.stack([turn @ cv2.Rodrigues(random.normal(0, 0.01, 3))[0] for turn in turns])
    blurred[0] = turns[0]
    start = Scene(blurred, shifts + random.normal(0, 0.02, (4, 3)) * (np.arange(4) > 0)[:, None],
                  points + random.normal(0, 0.1, (60, 3)), frame, point, exact.seen)  # fmt: skip
    found = adjust(start, 1.0, 50, 1e-12)
    assert np.abs(found.residuals()).max() < 1e-6 < np.abs(start.residuals()).max()
    assert angle_deg(found.rotations[3].T @ turns[3]) < 1e-3


def adjusted_poses(folder: Path) -> dict[str, np.ndarray]:
    """Label → camera to world (4, 4), from the survey's own bundle adjustment."""
    chunk = ElementTree.parse(folder / "ImgCoords-TIR.xml").getroot().find("chunk")
    assert chunk is not None
    return {
        str(camera.get("label")): np.array((camera.findtext("transform") or "").split(), float).reshape(4, 4)
        for camera in chunk.iter("camera")
        if camera.find("transform") is not None
    }


@pytest.mark.slow
def test_a_real_facade_agrees_with_the_survey(rover_data: Path) -> None:
    files = sorted((rover_data / "dunr/tiff").iterdir())[:8]
    camera = CameraModel("wiris", 640, 512, 767.128, 767.128, 312.085, 257.255, 0.0,
                         (-0.0431578, 0.3684112, 9.3220e-05, -0.00063889))  # fmt: skip
    found = track_sequence([read_picture(file) for file in files], camera, SequenceSettings())
    assert len(found) == len(files)
    poses = adjusted_poses(rover_data / "dunr")
    truth = [poses[file.stem] for file in files]
    turned, aside = [], []
    for a, b in pairwise(found):
        turn, shift = relative(a, b)
        step = np.linalg.inv(truth[a.frame]) @ truth[b.frame]
        turned.append(angle_deg(turn.T @ step[:3, :3]))
        aside.append(between_deg(shift, step[:3, 3]))
    assert np.median(turned) < 0.5
    assert np.median(aside) == pytest.approx(0.0, abs=3.0)
