"""The localizer on a driven scene: accurate, honest about it, deterministic, and refusing what it can't trust."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.geometry import Pose2, wrap_angle
from rover.vision.camera.file import load_camera
from rover.vision.localization.fix import Fix
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.settings import LocalizerSettings

from companion.tests.vision.thermal_scene import FRAME_STEPS, STEP, Drive, ThermalScene, drive, texture, with_wheels

LATENCY_STEPS = 3
START_SIGMA = (0.005, 0.005, 0.005)
CAMERA = load_camera("lepton-160")


@dataclass
class Run:
    """Errors (N, 3) of x, y, heading after each frame, fused and by the wheels, and what the localizer said."""

    localizer: Localizer
    fused: list[np.ndarray] = field(default_factory=list)
    wheels: list[np.ndarray] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    fixes: list[Fix] = field(default_factory=list)

    def rms(self, errors: list[np.ndarray]) -> float:
        return float(np.sqrt(np.mean(np.sum(np.array(errors)[:, :2] ** 2, axis=1))))

    @property
    def heading_rms(self) -> float:
        return float(np.sqrt(np.mean(np.array(self.fused)[:, 2] ** 2)))


def error(estimate: Pose2, truth: Pose2) -> np.ndarray:
    return np.array([estimate.x - truth.x, estimate.y - truth.y, wrap_angle(estimate.heading - truth.heading)])


def follow(seed: int, path: Drive, start: Pose2 | None = None) -> Run:
    """Drives `path` with frames every 0.12 s that arrive 60 ms late."""
    rng = np.random.default_rng(seed)
    scene = ThermalScene(CAMERA, texture(rng), rng)
    run = Run(Localizer(CAMERA, start or path.poses[0], START_SIGMA))
    late: list[tuple[int, Frame]] = []
    for step in range(1, len(path.poses)):
        run.localizer.predict(step * STEP, path.left[step - 1], path.right[step - 1])
        if step % FRAME_STEPS == 0:
            late.append((step + LATENCY_STEPS, scene.frame(path.poses[step], step * STEP, step // FRAME_STEPS)))
        if late and late[0][0] <= step:
            run.fixes.append(run.localizer.observe(late.pop(0)[1]))
            fused = error(run.localizer.pose, path.poses[step])
            run.fused.append(fused)
            run.wheels.append(error(run.localizer.odometry_only, path.poses[step]))
            run.nees.append(float(fused @ np.linalg.solve(run.localizer.covariance, fused)))
    return run


def disturbed(pose: Pose2, rng: np.random.Generator) -> Pose2:
    dx, dy, dh = rng.standard_normal(3) * START_SIGMA
    return Pose2(pose.x + dx, pose.y + dy, pose.heading + dh)


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """Three drives of some 3 m with turns in place, 3 % slip, each started a little beside where it is told."""
    made = []
    for seed in range(3):
        rng = np.random.default_rng(100 + seed)
        path = drive(rng, 2.0, slip=0.03)
        made.append(follow(seed, path, disturbed(path.poses[0], rng)))
    return made


@pytest.mark.slow
def test_the_fused_pose_stays_within_3_cm_and_1_degree(runs: list[Run]) -> None:
    for run in runs:
        assert run.rms(run.fused) < 0.03
        assert math.degrees(run.heading_rms) < 1.0


def test_vision_is_what_makes_it_so(runs: list[Run]) -> None:
    assert np.mean([r.rms(r.wheels) for r in runs]) > 3.0 * np.mean([r.rms(r.fused) for r in runs])


def test_the_covariance_is_honest(runs: list[Run]) -> None:
    # Three degrees of freedom: 3 on average. Errors of one drive hang together, hence the wide bounds.
    assert 0.8 < np.mean([np.mean(r.nees) for r in runs]) < 5.0


def test_nearly_every_frame_is_taken(runs: list[Run]) -> None:
    for run in runs:
        assert np.mean([fix.accepted for fix in run.fixes]) > 0.95


def spin(speed: float, turns: float) -> list[Pose2]:
    count = int(2.0 * math.pi * turns / speed / STEP)
    return [Pose2(1.5, 2.0, k * STEP * speed) for k in range(count + 1)]


def test_turning_in_place_at_full_speed_is_tracked_for_a_whole_turn_and_closes() -> None:
    path = with_wheels(np.random.default_rng(4), spin(1.2, 1.1), 0.03)
    run = follow(4, path)
    assert np.mean([fix.accepted for fix in run.fixes]) > 0.9
    assert np.hypot(*run.fused[-1][:2]) < 0.03
    assert abs(math.degrees(run.fused[-1][2])) < 1.0


def test_same_input_same_bytes() -> None:
    path = with_wheels(np.random.default_rng(4), spin(1.0, 0.15), 0.03)
    first, second = (follow(4, path) for _ in range(2))
    assert np.array(first.fused).tobytes() == np.array(second.fused).tobytes()
    assert first.localizer.covariance.tobytes() == second.localizer.covariance.tobytes()


@pytest.fixture
def standing() -> tuple[Localizer, ThermalScene]:
    rng = np.random.default_rng(0)
    scene = ThermalScene(CAMERA, texture(rng), rng)
    localizer = Localizer(CAMERA, Pose2(1.0, 1.0, 0.0), START_SIGMA)
    localizer.predict(0.0, 0.0, 0.0)
    localizer.observe(scene.frame(Pose2(1.0, 1.0, 0.0), 0.0, 0))
    return localizer, scene


def test_a_frame_taken_behind_the_shutter_changes_nothing(standing: tuple[Localizer, ThermalScene]) -> None:
    localizer, scene = standing
    localizer.predict(0.1, 0.01, 0.01)
    before = localizer.pose, localizer.covariance.copy()
    good = scene.frame(Pose2(1.0, 1.0, 0.0), 0.1, 1)
    fix = localizer.observe(Frame(good.counts, good.time, 1, ffc=True))
    assert not fix.accepted
    assert "shutter" in fix.reason
    assert localizer.pose == before[0]
    np.testing.assert_array_equal(localizer.covariance, before[1])


def test_a_picture_without_texture_is_refused(standing: tuple[Localizer, ThermalScene]) -> None:
    localizer, _ = standing
    localizer.predict(0.1, 0.0, 0.0)
    fix = localizer.observe(Frame(np.full((120, 160), 30000, np.uint16), 0.1, 1))
    assert not fix.accepted
    assert fix.reason


def test_a_picture_of_other_ground_is_refused_and_uncertainty_grows(standing: tuple[Localizer, ThermalScene]) -> None:
    localizer, scene = standing
    before = np.trace(localizer.covariance[:2, :2])
    for step in range(1, 6):
        localizer.predict(step * 0.12, 0.03, 0.03)
        fix = localizer.observe(scene.frame(Pose2(2.6, 3.0, 2.0), step * 0.12, step))
        assert not fix.accepted
    assert np.trace(localizer.covariance[:2, :2]) > before


def test_wheels_alone_follow_an_arc_and_pose_at_goes_back_along_it() -> None:
    localizer = Localizer(CAMERA, Pose2(0.0, 0.0, 0.0), START_SIGMA)
    localizer.predict(0.0, 0.0, 0.0)
    quarter = math.pi / 2.0
    for step in range(1, 21):
        localizer.predict(step * STEP, quarter * 0.4 / 20.0, quarter * 0.6 / 20.0)
    assert localizer.pose.distance(Pose2(0.5, 0.5, quarter)) < 0.01
    assert localizer.odometry_only.distance(Pose2(0.5, 0.5, quarter)) < 0.001
    half = localizer.pose_at(10 * STEP)
    assert half.distance(Pose2(0.5 * math.sin(quarter / 2), 0.5 * (1 - math.cos(quarter / 2)), 0.0)) < 0.01
    assert half.heading == pytest.approx(quarter / 2, abs=0.02)


@pytest.mark.slow
def test_frames_alone_stay_within_8_cm() -> None:
    rng = np.random.default_rng(8)
    path = drive(rng, 2.0, slip=0.0)
    scene = ThermalScene(CAMERA, texture(rng), rng)
    localizer = Localizer(CAMERA, path.poses[0], START_SIGMA, LocalizerSettings(motion="frames"))
    errors = []
    for step in range(FRAME_STEPS, len(path.poses), FRAME_STEPS):
        assert localizer.observe(scene.frame(path.poses[step], step * STEP, step)).accepted
        errors.append(error(localizer.pose, path.poses[step]))
    assert np.hypot(*np.array(errors)[:, :2].T).max() < 0.08
    assert abs(math.degrees(errors[-1][2])) < 2.0


def test_frames_alone_take_no_wheels() -> None:
    localizer = Localizer(CAMERA, Pose2(0.0, 0.0, 0.0), START_SIGMA, LocalizerSettings(motion="frames"))
    with pytest.raises(ValueError, match="frames alone"):
        localizer.predict(0.1, 0.01, 0.01)


@pytest.fixture
def driven() -> tuple[Localizer, ThermalScene, Drive, float]:
    """A localizer after two metres, its scene, the way, and the time reached."""
    rng = np.random.default_rng(12)
    path = drive(rng, 2.0)
    scene = ThermalScene(CAMERA, texture(rng), rng)
    localizer = Localizer(CAMERA, path.poses[0], START_SIGMA)
    for step in range(1, len(path.poses)):
        localizer.predict(step * STEP, path.left[step - 1], path.right[step - 1])
        if step % FRAME_STEPS == 0:
            localizer.observe(scene.frame(path.poses[step], step * STEP, step))
    return localizer, scene, path, len(path.poses) * STEP


@pytest.mark.slow
def test_kidnapped_to_a_known_place_it_is_found_within_3_frames(
    driven: tuple[Localizer, ThermalScene, Drive, float],
) -> None:
    localizer, scene, path, time = driven
    place = path.poses[len(path.poses) // 3].compose(Pose2(0.03, -0.02, 0.1))
    for count in range(1, 4):
        localizer.predict(time + 0.12 * count, 0.0, 0.0)
        fix = localizer.observe(scene.frame(place, time + 0.12 * count, count))
        assert fix.accepted or fix.reason
        if fix.accepted:
            break
    assert fix.reason == "relocated"
    assert not localizer.lost
    assert localizer.pose.distance(place) < 0.03
    assert abs(math.degrees(wrap_angle(localizer.pose.heading - place.heading))) < 1.0


@pytest.mark.slow
def test_kidnapped_to_a_place_never_seen_it_says_that_it_is_lost_until_it_is_brought_back(
    driven: tuple[Localizer, ThermalScene, Drive, float],
) -> None:
    localizer, scene, path, time = driven
    before = np.trace(localizer.covariance[:2, :2])
    keyframes = len(localizer.keyframes)
    away, back = Pose2(4.5, -1.0, 2.0), path.poses[40]
    for count in range(1, 9):
        localizer.predict(time + 0.12 * count, 0.0, 0.0)
        assert not localizer.observe(scene.frame(away, time + 0.12 * count, count)).accepted
        assert localizer.lost == (count >= 3)
    assert np.trace(localizer.covariance[:2, :2]) > 4.0 * before
    assert len(localizer.keyframes) == keyframes, "nothing is learned while it is lost"
    for count in range(9, 12):
        localizer.predict(time + 0.12 * count, 0.0, 0.0)
        localizer.observe(scene.frame(back, time + 0.12 * count, count))
    assert not localizer.lost
    assert localizer.pose.distance(back) < 0.03
