"""What one run has learned of the ground, a next run uses: it knows where it is, or says that it does not."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.cli.main import invoke
from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle
from rover.vision.camera.file import load_camera
from rover.vision.localization.keyframe_map import FILE_NAME, KeyframeMap, load_map, save_map
from rover.vision.localization.localizer import Localizer
from rover.vision.tracking.ground_track import camera_in_map

from companion.tests.vision.thermal_scene import FRAME_STEPS, STEP, Drive, ThermalScene, drive, texture

CAMERA = load_camera("lepton-160")
START_SIGMA = (0.005, 0.005, 0.005)
GROUND_SEED = 12


def scene_of_run(run: int) -> ThermalScene:
    """The same ground for every run, the camera's noise and pattern of each its own."""
    return ThermalScene(CAMERA, texture(np.random.default_rng(GROUND_SEED)), np.random.default_rng([GROUND_SEED, run]))


@pytest.fixture(scope="module")
def first_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, KeyframeMap, Drive]:
    """The folder of a run of two metres with its map in it, the map, and the way driven."""
    path = drive(np.random.default_rng(GROUND_SEED), 2.0)
    scene = scene_of_run(1)
    localizer = Localizer(CAMERA, path.poses[0], START_SIGMA)
    for step in range(1, len(path.poses)):
        localizer.predict(step * STEP, path.left[step - 1], path.right[step - 1])
        if step % FRAME_STEPS == 0:
            localizer.observe(scene.frame(path.poses[step], step * STEP, step))
    folder = tmp_path_factory.mktemp("run")
    save_map(folder / FILE_NAME, localizer.map, CAMERA)
    return folder, localizer.map, path


def restarted(folder: Path) -> Localizer:
    """A localizer that has the map and is told a start far from anything."""
    return Localizer(CAMERA, Pose2(-20.0, 30.0, 1.0), START_SIGMA, known=load_map(folder, CAMERA))


@pytest.mark.slow
def test_a_map_comes_back_from_its_file_as_it_was(first_run: tuple[Path, KeyframeMap, Drive], tmp_path: Path) -> None:
    folder, known, _ = first_run
    loaded = load_map(folder, CAMERA)
    for submap, former in zip(loaded.submaps, known.submaps, strict=True):
        np.testing.assert_array_equal(submap.poses, former.poses)
        np.testing.assert_array_equal(submap.covariance, former.covariance)
    for one, other in zip(loaded.frames, known.frames, strict=True):
        np.testing.assert_array_equal(one.descriptors, other.descriptors)
        np.testing.assert_array_equal(one.ground, other.ground)
    save_map(tmp_path / "again.npz", loaded, CAMERA)
    assert (tmp_path / "again.npz").read_bytes() == (folder / FILE_NAME).read_bytes()


@pytest.mark.parametrize("share", [0.1, 0.45, 0.8])
def test_restarted_on_ground_of_the_first_run_it_is_placed_within_3_frames_and_drives_on(
    first_run: tuple[Path, KeyframeMap, Drive], share: float
) -> None:
    folder, known, path = first_run
    scene, localizer = scene_of_run(2), restarted(folder)
    place = path.poses[int(share * len(path.poses))].compose(Pose2(0.03, -0.02, 0.1))
    assert restarted(folder).lost
    for count in range(1, 4):
        localizer.predict(0.12 * count, 0.0, 0.0)
        fix = localizer.observe(scene.frame(place, 0.12 * count, count))
        if fix.accepted:
            break
        assert math.sqrt(np.trace(localizer.covariance[:2, :2])) > 1.0, "until then it claims nothing"
    assert fix.reason == "relocated"
    assert not localizer.lost
    assert localizer.pose.distance(place) < 0.03
    assert abs(math.degrees(wrap_angle(localizer.pose.heading - place.heading))) < 1.0
    assert math.sqrt(np.trace(localizer.covariance[:2, :2])) < 0.03
    assert localizer.odometry_only.distance(place) < 0.03, "the wheels count from where it was recognised"
    for count in range(4, 10):
        place = place.compose(Pose2(0.02, 0.0, 0.0))
        localizer.predict(0.12 * count, 0.02, 0.02)
        assert localizer.observe(scene.frame(place, 0.12 * count, count)).accepted
    assert localizer.pose.distance(place) < 0.03
    assert len(localizer.keyframes) >= len(known.frames)


def test_restarted_on_ground_that_the_map_does_not_know_it_says_that_it_is_lost(
    first_run: tuple[Path, KeyframeMap, Drive],
) -> None:
    folder, known, _ = first_run
    scene, localizer = scene_of_run(3), restarted(folder)
    for count in range(1, 9):
        localizer.predict(0.12 * count, 0.0, 0.0)
        fix = localizer.observe(scene.frame(Pose2(4.5, -1.0, 2.0), 0.12 * count, count))
        assert not fix.accepted
        assert fix.reason
        assert localizer.lost
    assert len(localizer.keyframes) == len(known.frames), "nothing is learned while it is lost"
    assert math.sqrt(np.trace(localizer.covariance[:2, :2])) > 1.0


def test_another_camera_or_mount_is_refused_by_name(first_run: tuple[Path, KeyframeMap, Drive]) -> None:
    folder, _, _ = first_run
    with pytest.raises(BadInput, match="another camera or mount: z differ"):
        load_map(folder, replace(CAMERA, z=CAMERA.z + 0.01))
    assert load_map(folder, replace(CAMERA, name="renamed")).frames


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda content: b"", "damaged"),
        (lambda content: b"not a map\n" * 100, "damaged"),
        (lambda content: content[: len(content) // 2], "damaged"),
        (lambda content: content[:-1], "damaged"),
    ],
)
def test_a_damaged_file_is_one_line(
    first_run: tuple[Path, KeyframeMap, Drive], tmp_path: Path, damage: object, told: str
) -> None:
    assert callable(damage)
    file = tmp_path / "damaged.npz"
    file.write_bytes(damage((first_run[0] / FILE_NAME).read_bytes()))
    with pytest.raises(BadInput, match=told) as caught:
        load_map(file, CAMERA)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_flipped_bit_is_noticed_or_changes_nothing(
    first_run: tuple[Path, KeyframeMap, Drive], tmp_path: Path
) -> None:
    content = (first_run[0] / FILE_NAME).read_bytes()
    random = np.random.default_rng(1)
    # Headers of the members and the directory at the end, where a flip can do other things than spoil a checksum.
    places = [*range(0, 250, 3), *range(len(content) - 600, len(content), 7), *random.integers(0, len(content), 40)]
    noticed = 0
    for place in places:
        spoilt = bytearray(content)
        spoilt[place] ^= 1 << int(random.integers(8))
        file = tmp_path / "flipped.npz"
        file.write_bytes(spoilt)
        try:
            loaded = load_map(file, CAMERA)
        except BadInput:
            noticed += 1
            continue
        for submap, known in zip(loaded.submaps, first_run[1].submaps, strict=True):
            np.testing.assert_array_equal(submap.poses, known.poses)
        np.testing.assert_array_equal(loaded.frames[-1].descriptors, first_run[1].frames[-1].descriptors)
    assert noticed > len(places) // 2


def test_a_later_version_is_refused_by_its_number(first_run: tuple[Path, KeyframeMap, Drive], tmp_path: Path) -> None:
    with np.load(first_run[0] / FILE_NAME) as archive:
        content = {name: archive[name] for name in archive.files}
    content["version"] = np.int64(99)
    np.savez(tmp_path / "later.npz", **content)
    with pytest.raises(BadInput, match="version 99"):
        load_map(tmp_path / "later.npz", CAMERA)


def test_a_folder_without_a_map_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no such keyframe map"):
        load_map(tmp_path, CAMERA)


def test_a_folder_of_frames_is_tracked_in_the_map_of_an_earlier_run(
    first_run: tuple[Path, KeyframeMap, Drive], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    folder, _, path = first_run
    scene, start = scene_of_run(4), path.poses[len(path.poses) // 3]
    way = [start.compose(Pose2(0.01 * step, 0.0, 0.0)) for step in range(12)]
    for step, pose in enumerate(way):
        cv2.imwrite(str(tmp_path / f"{step:03d}.png"), scene.frame(pose, 0.12 * step, step).counts)
    options = ["track", str(tmp_path), "--camera", "lepton-160", "--map", str(folder), "--json"]
    assert invoke([*options, "--ground-plane"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert told["tracked"] >= 10
    assert told["poses"][0]["frame"] <= 2
    for pose in told["poses"]:
        position, _ = camera_in_map(way[pose["frame"]], CAMERA)
        assert math.hypot(pose["x"] - position[0], pose["y"] - position[1]) < 0.04
    assert invoke(options) == 2
    assert "--ground-plane" in capfd.readouterr().err
