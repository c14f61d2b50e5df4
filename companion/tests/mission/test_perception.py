"""What a mission suspects, reports and keeps its wheels away from."""

from __future__ import annotations

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.detection.classifier import Classifier, default_model
from rover.detection.ground.detect import Detection
from rover.detection.place import Anchor, Place
from rover.geometry import Pose2
from rover.mission.config import load
from rover.mission.perception import TOUCH_SPEED, Perception
from rover.vehicle import Vehicle
from rover.vision.camera.file import load_camera
from rover.vision.localization.keyframes import Keyframe
from rover.vision.localization.motion_model import ROBOT


@pytest.fixture(scope="module")
def perception() -> Perception:
    mission = load("demo")
    return Perception(mission, Vehicle(), load_camera(mission.rover.camera), Classifier(default_model()))


def place(number: int, mine: float, views: int = 5, x: float = 1.0, suspected: bool = False) -> Place:
    p = {"obstacle": 0.0, "surface": 0.0, "buried": mine, "background": 1.0 - mine}
    return Place(number, x, 1.0, 0.0, 0.0, p=p, views=views, suspected=suspected, indication=suspected)


def numbers(places: list[Place]) -> set[int]:
    return {one.id for one in places}


def test_no_wheel_goes_where_a_mine_is_not_unlikely_though_it_is_neither_reported_nor_visited(perception) -> None:
    places = [place(1, 0.9, suspected=True), place(2, 0.2), place(3, 0.1), place(4, 0.2, views=2)]
    perception.evidence.restore(places, 5)
    assert numbers(perception.suspected) == {1}
    assert numbers(perception.avoided) == {1, 2}


def test_what_was_inspected_and_is_no_indication_stays_avoided_while_it_is_not_unlikely(perception) -> None:
    one = place(1, 0.25, suspected=True)
    one.indication = False
    perception.evidence.restore([one], 2)
    perception.released.add(1)
    assert numbers(perception.suspected) == set()
    assert numbers(perception.avoided) == {1}


def test_places_outside_the_area_close_no_ground(perception) -> None:
    perception.evidence.restore([place(1, 0.25, x=-0.2)], 2)
    assert perception.avoided == []


def test_how_far_the_launch_is_does_not_matter_to_whether_the_rover_may_drive(perception) -> None:
    """Rover and ground are off together by 30 cm: all that is driven by is still where it was seen."""
    localizer = perception.localizer
    localizer.filter.add_keyframe(np.diag(np.square((0.002, 0.002, 0.004))))
    localizer.keyframes.add(Keyframe(np.zeros((1, 2)), np.zeros((1, 32), np.uint8), np.ones(1), 0.0))
    together = np.kron(np.ones((2, 2)), np.diag((0.09, 0.09, 0.0)))
    of_both = np.ix_(*2 * ([0, 1, 2, ROBOT, ROBOT + 1, ROBOT + 2],))
    localizer.filter.covariance[of_both] += together
    localizer.predict(0.0, 0.0, 0.0)
    localizer.observe(Frame(np.full((120, 160), 30000, np.uint16), 0.0, 1))
    assert perception.sigma > 0.25
    assert perception.relative_sigma < 0.02
    assert perception.placed
    localizer.filter.doubt((0.08, 0.08, 0.0))
    assert not perception.placed


def test_when_a_loop_is_closed_all_that_was_seen_from_a_submap_moves_with_it(perception) -> None:
    atlas, graph = perception.localizer.atlas, perception.localizer.atlas.graph
    atlas.begin()
    perception._follow_submaps()
    here, there = place(11, 0.9, suspected=True), place(12, 0.9, x=2.0, suspected=True)
    there.submap, there.anchor = 1, Anchor(3.0, Pose2(1.5, 1.0, 0.0))
    perception.evidence.restore([here, there], 13)
    perception.keepout.update(perception.avoided, 4.0)
    before = {zone.id: zone for zone in perception.keepout.active}
    assert perception.shift() is None
    shift = Pose2(0.04, -0.03, 0.02)
    graph.poses = [graph.poses[0], shift.compose(graph.poses[1])]
    perception._follow_submaps()
    moved = shift.transform(np.array([[2.0, 1.0]]))[0]
    assert (here.x, here.y) == (1.0, 1.0)
    np.testing.assert_allclose((there.x, there.y), moved)
    after = {zone.id: zone for zone in perception.keepout.active}
    assert after[11] == before[11]
    np.testing.assert_allclose((after[12].x, after[12].y), moved)
    assert (after[12].since, after[12].radius) == (before[12].since, before[12].radius)
    assert not [zone for zone in perception.keepout.history if zone.until is not None], "it is no new zone"
    seen_from = after[12].anchor.pose
    assert seen_from.relative_to(shift).distance(Pose2(1.5, 1.0, 0.0)) < 1e-9
    told = perception.shift()
    assert told is not None
    assert told.distance(shift) < 1e-12, "the rover stands on that ground"


def test_a_place_goes_on_being_averaged_where_its_submap_has_moved_to() -> None:
    one = place(1, 0.9)
    pose, found = Pose2(0.5, 1.0, 0.0), Detection(0.5, 0.0, 0.1, {"obstacle": 0.0, "surface": 0.0, "buried": 1.0,
                                                                  "background": 0.0}, (0, 0, 1, 1))  # fmt: skip
    one.add(found, np.array([1.0, 1.0]), pose, 1.0, (1e-4, 1e-5), 1.0)
    one.move(Pose2(0.1, 0.0, 0.0))
    one.add(found, np.array([1.1, 1.0]), pose, 1.0, (1e-4, 1e-5), 2.0)
    assert one.x == pytest.approx(1.1)
    assert one.y == pytest.approx(1.0)


def test_the_rover_is_slow_on_ground_that_nothing_has_judged_and_close_past_what_stands() -> None:
    mission = load("demo")
    perception = Perception(mission, Vehicle(), load_camera(mission.rover.camera), Classifier(default_model()))
    launch = mission.launch.pose
    assert perception.speed_limit(launch.x, launch.y) > 1.0, "the operator has surveyed it"
    assert perception.speed_limit(2.0, 2.0) == TOUCH_SPEED
    perception.parallax.bear(2.0, 2.0, 0.5)
    assert perception.speed_limit(2.0, 2.0) > 1.0
    perception.grid.occupied[100, 110] = True
    assert perception.speed_limit(2.02, 2.0) == TOUCH_SPEED
    assert perception.speed_limit(1.9, 2.0) > 1.0
