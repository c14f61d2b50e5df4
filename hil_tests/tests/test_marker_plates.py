"""Marker plates of the simulated ground in the simulated camera's pictures, and what the map makes of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.detection.classifier import Classifier, default_model
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.link.telemetry import WheelMotion
from rover.mission.config import Mission, from_document
from rover.mission.perception import Perception
from rover.vehicle import STANDARD
from rover.vision.camera.file import load_camera
from rover.vision.localization.cold_plate import ColdSpot, cold_spots, colder, without
from rover_hil.ground import build
from rover_hil.plant_config import build_plant
from rover_plant import Plant

CAMERA = load_camera("lepton-160")
PLATE = (1.6, 1.25)


def a_mission(
    hour: str = "13:00", plates: Any = (PLATE,), launch: tuple[float, float, float] = (1.0, 1.0, 20.0)
) -> Mission:
    x, y, heading = launch
    document = {
        "mission": {"time_of_day": hour},
        "area": {"width_m": 3.0, "height_m": 3.0},
        "launch": {"x_m": x, "y_m": y, "heading_deg": heading},
        "markers": {"plates": [list(plate) for plate in plates]},
    }
    return from_document(document, Path("plates.toml"))


def frames(plant: Plant, count: int) -> list[Frame]:
    found: list[Frame] = []
    while len(found) < count:
        plant.step(0.0, 0.0, True)
        for sequence, exposure_us, _, ffc, pixels in plant.take_frames():
            counts = np.frombuffer(pixels, "<u2").reshape(120, 160).astype(np.uint16)
            found.append(Frame(counts, exposure_us * 1e-6, sequence, ffc))
    return found


def spots_in(frame: Frame, mission: Mission) -> list[ColdSpot]:
    return cold_spots(frame, CAMERA, mission.plates.side, colder(mission.time_of_day_s / 3600.0))


def a_plant(mission: Mission, seed: int = 4) -> Plant:
    return build_plant(mission, build(mission, seed), CAMERA, seed)


@pytest.mark.parametrize("hour", ["06:00", "13:00", "22:00"])
def test_a_plate_is_found_to_a_centimetre_at_every_hour(hour: str) -> None:
    mission = a_mission(hour)
    (frame,) = frames(a_plant(mission), 1)
    (spot,) = spots_in(frame, mission)
    expected = mission.launch.pose.inverse().transform(np.array([PLATE]))[0]
    assert spot.whole
    assert np.hypot(spot.x - expected[0], spot.y - expected[1]) < min(0.01, 2.0 * spot.sigma)


@pytest.mark.parametrize("hour", ["13:00", "22:00"])
def test_nothing_else_of_a_field_is_as_cold_as_a_plate(hour: str) -> None:
    """Rocks and tufts all around, sunlit and in the shade."""
    for seed in range(2):
        for heading in (0.0, 180.0):
            mission = a_mission(hour, (), (1.5, 1.5, heading))
            (frame,) = frames(a_plant(mission, seed), 1)
            assert spots_in(frame, mission) == []


def test_a_plate_that_is_cut_by_the_picture_s_edge_is_not_measured() -> None:
    mission = a_mission(launch=(1.35, 1.14, 20.0))  # too near: its front is below the picture
    (frame,) = frames(a_plant(mission), 1)
    spots = spots_in(frame, mission)
    assert spots
    assert not any(spot.whole for spot in spots)


def test_the_rest_of_the_rover_sees_plain_ground_where_a_plate_lies() -> None:
    mission = a_mission()
    (frame,) = frames(a_plant(mission), 1)
    spots = spots_in(frame, mission)
    plain = without(frame, spots)
    assert frame.kelvin().min() < 290.0  # the plate
    kelvin = plain.kelvin()
    assert abs(float(np.median(kelvin)) - float(kelvin[spots[0].mask].mean())) < 2.0
    assert spots_in(plain, mission) == []
    changed = frame.counts != plain.counts
    assert not (changed & ~spots[0].mask).any()


def driven(mission: Mission, believed: Pose2, count: int = 4) -> Perception:
    """What a rover at rest knows after some frames, set down where the mission says, which it believes wrongly."""
    wrong = replace(mission, launch=replace(mission.launch, pose=believed))
    perception = Perception(wrong, STANDARD, CAMERA, Classifier(default_model()))
    plant = a_plant(mission)
    perception.localizer.atlas.graph.sigma = (0.1, 0.1, 0.01)
    perception.localizer.atlas.graph.solve()
    perception.take(WheelMotion(0.0, 0, 0))
    for frame in frames(plant, count):
        perception.take(WheelMotion(frame.time, 0, 0))
        perception.see(frame, frame.time + 0.06)
    return perception


def test_a_plate_that_is_seen_puts_the_map_right_and_tells_how_far_it_was_off() -> None:
    mission = a_mission()
    true = mission.launch.pose
    perception = driven(mission, Pose2(true.x - 0.12, true.y + 0.09, true.heading))
    assert np.hypot(perception.pose.x - true.x, perception.pose.y - true.y) < 0.03
    (plate,) = perception.markers.told(perception.localizer)
    assert plate.seen
    assert plate.off == pytest.approx(0.15, abs=0.02)
    assert perception.sigma < 0.03


def test_without_its_plate_in_view_the_map_stays_where_it_was() -> None:
    mission = a_mission(plates=((2.8, 2.8),))
    true = mission.launch.pose
    perception = driven(mission, Pose2(true.x - 0.12, true.y + 0.09, true.heading))
    assert np.hypot(perception.pose.x - true.x, perception.pose.y - true.y) == pytest.approx(0.15, abs=0.02)
    (plate,) = perception.markers.told(perception.localizer)
    assert not plate.seen
    assert plate.off is None
    assert perception.sigma > 0.08


def test_a_plate_is_neither_an_obstacle_nor_an_indication_and_no_wheel_goes_over_it() -> None:
    mission = a_mission()
    perception = driven(mission, mission.launch.pose, 8)
    row, column = (round(value / perception.grid.resolution) for value in (PLATE[1], PLATE[0]))
    around = np.s_[row - 12 : row + 13, column - 12 : column + 13]
    assert perception.grid.seen[row, column]
    assert not perception.grid.occupied[around].any()
    assert all(np.hypot(place.x - PLATE[0], place.y - PLATE[1]) > 0.2 for place in perception.evidence.places)
    (zone,) = (zone for zone in perception.zones if zone not in perception.keepout.active)
    assert np.hypot(zone.x - PLATE[0], zone.y - PLATE[1]) < 0.02
    assert zone.radius > 0.5 * mission.plates.side


def test_two_plates_that_could_be_taken_for_each_other_are_refused() -> None:
    with pytest.raises(BadInput, match="could not be told apart"):
        a_mission(plates=((1.0, 1.0), (1.5, 1.0)))
    with pytest.raises(BadInput, match="outside the area"):
        a_mission(plates=((4.0, 1.0),))
