"""What a mission suspects, reports and keeps its wheels away from."""

from __future__ import annotations

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.detection.classifier import Classifier, default_model
from rover.detection.place import Place
from rover.mission.config import load
from rover.mission.perception import Perception
from rover.vehicle import Vehicle
from rover.vision.camera.file import load_camera
from rover.vision.localization.keyframes import Keyframe


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
    localizer.keyframes.add(
        Keyframe(np.zeros((1, 2)), np.zeros((1, 32), np.uint8), np.ones(1), 0.0), localizer.filter.keyframe_poses()
    )
    together = np.kron(np.ones((2, 2)), np.diag((0.09, 0.09, 0.0)))
    of_both = np.ix_([0, 1, 2, 5, 6, 7], [0, 1, 2, 5, 6, 7])
    localizer.filter.covariance[of_both] += together
    localizer.predict(0.0, 0.0, 0.0)
    localizer.observe(Frame(np.full((120, 160), 30000, np.uint16), 0.0, 1))
    assert perception.sigma > 0.25
    assert perception.relative_sigma < 0.02
    assert perception.placed
    localizer.filter.doubt((0.08, 0.08, 0.0))
    assert not perception.placed
