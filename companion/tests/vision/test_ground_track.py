"""`rover track --ground-plane`: metric camera poses from frames that the scene of these tests has drawn."""

from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.cli.main import invoke
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera
from rover.vision.tracking.ground_track import camera_in_map

from companion.tests.vision.thermal_scene import START, ThermalScene, texture

CAMERA = load_camera("lepton-160")
STEPS = 40


def arc() -> list[Pose2]:
    """1 m along an arc of 1 m radius, from START."""
    turned = [0.025 * step for step in range(STEPS)]
    return [START.compose(Pose2(math.sin(a), 1.0 - math.cos(a), a)) for a in turned]


@pytest.fixture
def frames(tmp_path: Path) -> Path:
    rng = np.random.default_rng(11)
    scene = ThermalScene(CAMERA, texture(rng), rng)
    for step, pose in enumerate(arc()):
        counts = scene.frame(pose, 0.12 * step, step).counts
        cv2.imwrite(str(tmp_path / f"{step:03d}.png"), np.full_like(counts, 30000) if step == 20 else counts)
    return tmp_path


def test_a_camera_over_flat_ground_is_tracked_in_metres(frames: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert invoke(["track", str(frames), "--camera", "lepton-160", "--ground-plane", "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert told["frames"] == STEPS
    assert told["tracked"] >= STEPS - 2
    assert 20 not in [pose["frame"] for pose in told["poses"]], "a frame that shows nothing is left out"
    for pose in told["poses"]:
        truth, turn = camera_in_map(arc()[pose["frame"]].relative_to(START), CAMERA)
        assert np.hypot(pose["x"] - truth[0], pose["y"] - truth[1]) < 0.02
        assert pose["z"] == pytest.approx(CAMERA.z)
        x, y, z, w = (pose[key] for key in ("qx", "qy", "qz", "qw"))
        forward = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        assert math.degrees(math.acos(min(1.0, float(forward @ turn[:, 2])))) < 1.0


def test_a_camera_that_looks_up_is_named(frames: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "up.toml"
    file.write_text(
        'name = "up"\nwidth = 160\nheight = 120\n[intrinsics]\nhfov_deg = 57\n[mount]\nz_m = 1.0\npitch_deg = -52\n'
    )
    assert invoke(["track", str(frames), "--camera", str(file), "--ground-plane"]) == 2
    assert "no pixel shows the ground" in capfd.readouterr().err
