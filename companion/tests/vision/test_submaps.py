"""The localizer over many submaps: as accurate as over one, no jump at a border, found again."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera
from rover.vision.localization.keyframe_map import FILE_NAME, load_map, save_map
from rover.vision.localization.keyframes import KeyframeSettings
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.settings import LocalizerSettings

from companion.tests.vision.thermal_scene import FRAME_STEPS, STEP, Drive, ThermalScene, drive, texture

CAMERA = load_camera("lepton-160")
START_SIGMA = (0.005, 0.005, 0.005)
SMALL = replace(LocalizerSettings(), keyframes=KeyframeSettings(limit=8))
GROUND_SEED = 31


def scene(run: int) -> ThermalScene:
    return ThermalScene(CAMERA, texture(np.random.default_rng(GROUND_SEED)), np.random.default_rng([GROUND_SEED, run]))


@dataclass
class Run:
    """errors (N, 2) of the position after each frame; jumps: what the pose did when a submap began, metres."""

    localizer: Localizer
    errors: np.ndarray
    refused: int
    jumps: list[float]


@pytest.fixture(scope="module")
def path() -> Drive:
    return drive(np.random.default_rng(GROUND_SEED), 6.5)


@pytest.fixture(scope="module")
def run(path: Drive) -> Run:
    ground, localizer = scene(1), Localizer(CAMERA, path.poses[0], START_SIGMA, SMALL)
    errors, jumps, refused, submaps = [], [], 0, 1
    for step in range(1, len(path.poses)):
        localizer.predict(step * STEP, path.left[step - 1], path.right[step - 1])
        if step % FRAME_STEPS:
            continue
        before = localizer.pose
        refused += not localizer.observe(ground.frame(path.poses[step], step * STEP, step)).accepted
        errors.append((localizer.pose.x - path.poses[step].x, localizer.pose.y - path.poses[step].y))
        if len(localizer.atlas.submaps) > submaps:
            submaps = len(localizer.atlas.submaps)
            jumps.append(localizer.pose.distance(before))
            assert localizer.pose_at(step * STEP - 0.05).distance(path.poses[step - 2]) < 0.06
    return Run(localizer, np.array(errors), refused, jumps)


@pytest.mark.slow
def test_over_many_small_submaps_the_pose_stays_within_3_cm(run: Run) -> None:
    submaps = run.localizer.atlas.submaps
    assert len(submaps) >= 3
    assert all(len(submap.keyframes) <= SMALL.keyframes.limit for submap in submaps)
    assert run.refused <= 0.05 * len(run.errors)
    assert math.sqrt(np.mean(np.sum(run.errors**2, axis=1))) < 0.03


@pytest.mark.slow
def test_from_one_submap_to_the_next_the_pose_does_not_jump(run: Run) -> None:
    assert run.jumps
    assert max(run.jumps) < 0.02


@pytest.mark.slow
def test_ground_of_another_submap_leads_back_into_that_one_and_closes_loops(run: Run) -> None:
    atlas = run.localizer.atlas
    assert len(atlas.graph.edges) > len(atlas.submaps) - 1
    assert atlas.moves > 0


@pytest.mark.slow
def test_restarted_in_any_submap_it_is_found(run: Run, path: Drive, tmp_path: Path) -> None:
    save_map(tmp_path / FILE_NAME, run.localizer.map, CAMERA)
    ground = scene(2)
    for share in (0.1, 0.45, 0.9):
        localizer = Localizer(CAMERA, Pose2(0.0, 0.0, 0.0), START_SIGMA, SMALL, known=load_map(tmp_path, CAMERA))
        place = path.poses[int(share * len(path.poses))]
        for count in range(2 * len(run.localizer.atlas.submaps) + 2):
            localizer.predict(0.12 * count, 0.0, 0.0)
            if localizer.observe(ground.frame(place, 0.12 * count, count)).accepted:
                break
        assert not localizer.lost
        assert localizer.pose.distance(place) < 0.05
        assert math.sqrt(np.trace(localizer.relative_covariance[:2, :2])) < 0.02
