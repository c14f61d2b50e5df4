"""The referee: ground seen and unseen, contacts, keep-out zones, mines; all from the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from rover_hil.ground import Mine
from rover_hil.referee import judge_mines, judge_zones, wheel_distance
from rover_hil.testing.plants import NO_SLIP, SAME_MOTORS, cell_centres, drive, make_plant
from rover_plant import Plant

STRAIGHT = {**NO_SLIP, **SAME_MOTORS}


def seen_at(plant: Plant, x: float, y: float) -> bool:
    raster, x0, y0, cell = plant.seen()
    return bool(raster[int((y - y0) / cell), int((x - x0) / cell)])


def test_before_the_first_frame_only_the_launch_disc_is_surveyed() -> None:
    plant = make_plant()
    raster, _, _, cell = plant.seen()
    assert raster.sum() * cell**2 == pytest.approx(math.pi * 0.25**2, rel=0.02)
    assert seen_at(plant, 2.0, 2.2)
    assert not seen_at(plant, 2.0, 2.3)


def test_a_frame_marks_its_trapezoid_on_the_ground() -> None:
    plant = make_plant()
    drive(plant, 0.0, 0.0, 0.109)
    assert not seen_at(plant, 3.0, 2.0)
    drive(plant, 0.0, 0.0, 0.001)
    # Depression of the upper and lower edge: 52° -/+ half the vertical field of view.
    half = math.atan(60 / (80 / math.tan(math.radians(28.5))))
    far = 0.75 / math.tan(math.radians(52.0) - half)
    near = 0.75 / math.tan(math.radians(52.0) + half)
    for distance, expected in ((near - 0.02, True), (near + 0.02, True), (far - 0.02, True), (far + 0.02, False)):
        assert seen_at(plant, 2.0 + distance, 2.0) == expected, distance
    half_width = 80 / (80 / math.tan(math.radians(28.5))) * 0.75 / math.sin(math.radians(52.0))
    middle = 2.0 + 0.75 / math.tan(math.radians(52.0))
    for offset, expected in ((half_width - 0.02, True), (half_width + 0.02, False)):
        assert seen_at(plant, middle, 2.0 + offset) == expected
        assert seen_at(plant, middle, 2.0 - offset) == expected


def test_the_shadow_of_a_post_stays_unseen() -> None:
    x, y = cell_centres()
    post = np.where(np.hypot(x - 2.8, y - 2.0) < 0.08, 0.15, 0.0)
    plant = make_plant(height=post)
    drive(plant, 0.0, 0.0, 0.5)
    assert seen_at(plant, 2.7, 2.0)
    assert seen_at(plant, 2.8, 2.0)
    # From 0.75 m the top edge at 0.88 m throws a shadow up to 0.88 * 0.75 / 0.60 = 1.10 m.
    for distance in (0.93, 1.0, 1.05):
        assert not seen_at(plant, 2.0 + distance, 2.0), distance
        assert seen_at(plant, 2.0 + distance, 2.3)
    assert seen_at(plant, 3.15, 2.0)


def test_frames_of_a_closed_shutter_survey_nothing() -> None:
    plant = make_plant(camera={"ffc_first_us": 0, "ffc_period_us": 100_000_000, "ffc_duration_us": 100_000_000})
    drive(plant, 0.0, 0.0, 1.0)
    assert not seen_at(plant, 2.6, 2.0)


def test_driving_ahead_over_surveyed_ground_costs_nothing_and_backing_out_of_it_does() -> None:
    # Askew to the cells, so that their size averages out.
    launch = {"x": 2.0, "y": 2.0, "heading": 0.3, "surveyed_radius": 0.25}
    ahead, back = (make_plant(drive=STRAIGHT, launch=launch) for _ in range(2))
    for plant in (ahead, back):
        drive(plant, 0.0, 0.0, 0.3)
    drive(ahead, 0.5, 0.5, 4.0)
    drive(back, -0.5, -0.5, 4.0)
    assert ahead.verdict()["unseen_ground_m2"] == 0.0
    travelled = (2.0 - back.pose()[0]) / math.cos(0.3)
    assert travelled > 0.5
    # Two wheels 2.5 cm wide; the launch disc covers them up to sqrt(0.25² - 0.1²) behind, the caster adds its own.
    expected = 2 * 0.025 * (travelled + 0.03 - math.sqrt(0.25**2 - 0.1**2)) + 0.024 * (travelled + 0.1 - 0.25)
    assert back.verdict()["unseen_ground_m2"] == pytest.approx(expected, rel=0.05)


def test_a_contact_is_counted_once_and_stops_the_rover() -> None:
    plant = make_plant(obstacles=[[2.6, 2.0, 0.1, 0.2]], drive=STRAIGHT)
    drive(plant, 0.5, 0.5, 4.0)
    assert plant.pose()[0] == pytest.approx(2.6 - 0.1 - 0.15, abs=1e-3)
    verdict = plant.verdict()
    assert verdict["collisions"] == 1
    assert verdict["min_clearance_m"] == pytest.approx(0.0, abs=1e-3)
    drive(plant, -0.5, -0.5, 0.5)
    drive(plant, 0.5, 0.5, 1.0)
    assert plant.verdict()["collisions"] == 2


def test_passing_beside_an_obstacle_leaves_its_clearance() -> None:
    plant = make_plant(obstacles=[[2.6, 2.33, 0.1, 0.2]], drive=STRAIGHT)
    drive(plant, 0.5, 0.5, 6.0)
    verdict = plant.verdict()
    assert verdict["collisions"] == 0
    assert verdict["min_clearance_m"] == pytest.approx(0.08, abs=1e-3)


def test_the_bounds_of_the_area_are_walls() -> None:
    plant = make_plant(launch={"x": 3.6, "y": 2.0, "heading": 0.0}, drive=STRAIGHT)
    drive(plant, 0.5, 0.5, 3.0)
    assert plant.pose()[0] == pytest.approx(4.0 - 0.15, abs=1e-6)
    assert plant.verdict()["collisions"] == 1
    assert plant.verdict()["min_wall_clearance_m"] == pytest.approx(0.0, abs=1e-6)
    assert plant.verdict()["min_clearance_m"] is None


def straight_track(seconds: float = 10.0, speed: float = 0.1) -> NDArray[np.float64]:
    """Along x from the origin, 100 Hz; the wheels run at y = ±0.10."""
    times = np.arange(0.0, seconds, 0.01)
    return np.column_stack([times, speed * times, np.zeros_like(times), np.zeros_like(times)])


def zone(t: float, x: float, y: float, r: float, **more: float) -> dict[str, float]:
    return {"id": 1, "t": t, "x": x, "y": y, "r": r, **more}


def test_the_distance_to_a_wheel_is_that_to_its_contact_patch() -> None:
    at_origin = np.array([[0.0, 0.0, 0.0, 0.0]])
    assert wheel_distance(at_origin, 0.0, 0.10) == 0.0
    assert wheel_distance(at_origin, 0.0, 0.0) == pytest.approx(0.10 - 0.0125)
    assert wheel_distance(at_origin, 0.13, -0.10) == pytest.approx(0.10)
    turned = np.array([[0.0, 0.0, 0.0, math.pi / 2]])
    assert wheel_distance(turned, -0.10, 0.13) == pytest.approx(0.10)


def test_driving_a_wheel_through_a_zone_is_a_violation() -> None:
    verdict = judge_zones(straight_track(), [zone(0.0, 0.5, 0.10, 0.05)])
    assert verdict["keepout_violations"] == 1
    assert verdict["zones_violated"] == [1]


def test_straddling_a_zone_is_none() -> None:
    assert judge_zones(straight_track(), [zone(0.0, 0.5, 0.0, 0.05)])["keepout_violations"] == 0


def test_a_zone_counts_from_half_a_second_after_its_declaration_until_its_end() -> None:
    track = straight_track()
    # The patch, 6 cm long, touches the 2 cm disc from x = 0.45 to 0.55: from 4.5 s to 5.5 s.
    assert judge_zones(track, [zone(3.9, 0.5, 0.10, 0.02)])["keepout_violations"] == 1
    assert judge_zones(track, [zone(5.6, 0.5, 0.10, 0.02)])["keepout_violations"] == 0
    assert judge_zones(track, [zone(0.0, 0.5, 0.10, 0.02, until=4.4)])["keepout_violations"] == 0
    # Driven into during the half second and still inside after it.
    assert judge_zones(track, [zone(4.4, 0.5, 0.10, 0.02)])["keepout_violations"] == 1


def test_leaving_a_zone_declared_under_a_wheel_is_reported_but_no_violation() -> None:
    verdict = judge_zones(straight_track(), [zone(5.0, 0.45, 0.10, 0.2)])
    assert verdict["zones_declared_under_wheel"] == [1]
    assert verdict["keepout_violations"] == 0


def test_going_deeper_into_a_zone_declared_under_a_wheel_is_a_violation() -> None:
    verdict = judge_zones(straight_track(), [zone(4.0, 0.55, 0.10, 0.2)])
    assert verdict["zones_declared_under_wheel"] == [1]
    assert verdict["keepout_violations"] == 1


def test_redrawing_a_zone_gives_no_new_grace_on_ground_that_it_covered_before() -> None:
    # Redrawn every 0.3 s while the rover drives through: without memory it would never count.
    versions = [zone(0.3 * k, 0.5 + 0.001 * k, 0.10, 0.05, until=0.3 * k + 0.3) for k in range(33)]
    assert judge_zones(straight_track(), versions)["keepout_violations"] == 1


def test_redrawing_a_zone_under_a_leaving_wheel_is_no_violation() -> None:
    versions = [zone(5.0, 0.45, 0.10, 0.2, until=6.0), zone(6.0, 0.46, 0.10, 0.2)]
    verdict = judge_zones(straight_track(), versions)
    assert verdict["zones_declared_under_wheel"] == [1]
    assert verdict["keepout_violations"] == 0


def mine(number: int, x: float, y: float, contrast: float = 2.0) -> Mine:
    return Mine(id=number, x=x, y=y, radius=0.055, depth=0.02, kind="buried", contrast_k=contrast)


def test_a_mine_under_a_wheel_is_counted_whatever_was_declared() -> None:
    verdict = judge_mines(straight_track(), [mine(1, 0.5, 0.14), mine(2, 0.5, 0.30)], [], area=12.0)
    assert verdict["wheel_over_mine"] == 1
    assert [row["driven_over"] for row in verdict["mines"]] == [True, False]


def test_a_mine_is_found_within_ten_centimetres_and_obstacles_do_not_count() -> None:
    detections = [
        {"x": 1.06, "y": 1.06, "class": "buried"},
        {"x": 2.0, "y": 2.12, "class": "surface"},
        {"x": 3.0, "y": 3.0, "class": "obstacle"},
    ]
    mines = [mine(1, 1.0, 1.0), mine(2, 2.0, 2.0), mine(3, 3.0, 3.0), mine(4, 0.2, 3.0, contrast=0.3)]
    verdict = judge_mines(straight_track(), mines, detections, area=10.0)
    assert [row["found"] for row in verdict["mines"]] == [True, False, False, False]
    assert (verdict["mines_with_contrast"], verdict["mines_with_contrast_found"]) == (3, 1)
    assert verdict["false_indications"] == 1
    assert verdict["false_indications_per_m2"] == pytest.approx(0.1)


def straight_on(off: float) -> NDArray[np.float64]:
    """A true way along y = 1 while the companion believes to be at y = 1 - off."""
    time = np.arange(0.0, 10.0, 0.01)
    return np.column_stack((time, 0.2 * time, np.ones_like(time), np.zeros_like(time)))


def seen_beside_the_way(believed_y: float, zone_y: float, turned: float = 0.0) -> dict[str, object]:
    """A zone drawn at 2 s, seen from x = 0.4 by a rover that believes to be at `believed_y`, turned by so much."""
    anchor = {"t": 2.0, "x": 0.4, "y": believed_y, "heading": turned}
    return {"t": 2.0, "id": 1, "x": 1.2, "y": zone_y, "r": 0.15, "anchor": anchor}


def test_a_zone_lies_on_the_ground_that_was_seen_however_far_the_map_is_off() -> None:
    truth = straight_on(0.2)
    # Believed at y = 0.8: a zone at 0.8 lies on the way, one at 1.0 lies 20 cm beside it, clear of a wheel at 10 cm.
    assert judge_zones(truth, [seen_beside_the_way(0.8, 0.8)])["keepout_violations"] == 1
    assert judge_zones(truth, [seen_beside_the_way(0.8, 1.07)])["keepout_violations"] == 0
    unanchored = {k: v for k, v in seen_beside_the_way(0.8, 1.07).items() if k != "anchor"}
    assert judge_zones(truth, [unanchored])["keepout_violations"] == 1


def test_an_anchored_zone_is_turned_with_the_map_that_it_was_drawn_on() -> None:
    truth, turned = straight_on(0.0), 0.5
    # 0.8 m straight ahead of the rover, whatever the map says of its heading.
    ahead = {"x": 0.4 + 0.8 * math.cos(turned), "y": 1.0 + 0.8 * math.sin(turned)}
    zone = {**seen_beside_the_way(1.0, 0.0, turned), **ahead}
    assert judge_zones(truth, [zone])["keepout_violations"] == 1


def test_a_mine_is_found_where_the_rover_really_saw_it() -> None:
    truth = straight_on(0.3)
    mines = [Mine(1, 1.2, 1.4, 0.055, 0.01, "buried", 2.0)]
    report = {"class": "buried", "x": 1.2, "y": 1.1, "anchor": {"t": 2.0, "x": 0.4, "y": 0.7, "heading": 0.0}}
    assert judge_mines(truth, mines, [report], 1.0)["mines"][0]["found"]
    del report["anchor"]
    assert not judge_mines(truth, mines, [report], 1.0)["mines"][0]["found"]
