"""`rover plan`, `rover register` and `rover detect`: the keys that scripts read, and refusals."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

FIELD = "width = 3.0\nheight = 4.0\nobstacles = [[2.0, 1.5, 0.2]]\n"
PLAN_KEYS = {"status", "algorithm", "order", "path", "length_m", "iterations", "nodes", "time_ms", "first_solution_ms"}


@pytest.fixture
def field(tmp_path):
    file = tmp_path / "field.toml"
    file.write_text(FIELD, encoding="utf-8")
    return file


@pytest.fixture
def texture(tmp_path):
    """Two pictures of the same texture, B shifted by (+12, +7) pixels."""
    rng = np.random.default_rng(3)
    big = cv2.GaussianBlur(rng.integers(0, 256, (300, 400), dtype=np.uint8), (0, 0), 2.0)
    big = cv2.normalize(big, None, 0, 255, cv2.NORM_MINMAX)
    a, b = tmp_path / "a.png", tmp_path / "b.png"
    cv2.imwrite(str(a), big[20:260, 20:340])
    cv2.imwrite(str(b), big[13:253, 8:328])
    return a, b


@pytest.mark.parametrize("algorithm", ["rrt", "rrt-star", "goal-seeking", "multi-goal"])
def test_a_plan_visits_its_goals(rover, field, algorithm):
    goals = ("--goal", "2,2.5", "--goal", "1.2,3.5")
    result = rover("plan", "--map", field, "--start", "2,0.5", *goals, "--algorithm", algorithm, "--json")
    plan = json.loads(result.out)
    assert result.code == 0
    assert set(plan) >= PLAN_KEYS
    assert (plan["status"], plan["order"], plan["path"][0], plan["path"][-1]) == ("ok", [0, 1], [2.0, 0.5], [1.2, 3.5])
    assert plan["length_m"] == pytest.approx(sum(map(np.linalg.norm, np.diff(plan["path"], axis=0))))


def test_the_order_counts_alike_for_people_and_scripts(rover, field):
    backwards = ("--goal", "1.2,3.5", "--goal", "2,2.5", "--any-order")
    said = rover("plan", "--map", field, "--start", "2,0.5", *backwards).out
    order = json.loads(rover("plan", "--map", field, "--start", "2,0.5", *backwards, "--json").out)["order"]
    assert order == [1, 0]
    assert "goals in the order 1, 0 (from 0)" in said


def test_a_goal_in_an_obstacle_is_no_path(rover, field):
    result = rover("plan", "--map", field, "--start", "2,0.5", "--goal", "2,1.5", "--algorithm", "rrt", "--json")
    assert (result.code, json.loads(result.out)["status"]) == (4, "no_path")
    assert result.err.startswith("rover: no path: goal 1")


@pytest.mark.parametrize("point", ["2", "2,3,4", "a,b", "nan,1", "9,9"])
def test_a_point_that_is_none_is_bad_input(rover, field, point):
    result = rover("plan", "--map", field, "--start", point, "--goal", "1,1")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "start" in result.err


@pytest.mark.parametrize(
    "switches",
    [
        (),
        ("--estimator", "ransac"),
        ("--cluster", "position"),
        ("--steps", "none"),
        ("--steps", "fixed-pattern,dead-pixels,gaussian,clahe"),
    ],
)
def test_a_registration_finds_the_shift(rover, texture, switches):
    result = rover("register", *texture, *switches, "--json")
    found = json.loads(result.out)
    assert (result.code, found["status"]) == (0, "ok")
    homography = np.array(found["homography"])
    corner = homography @ (100.0, 100.0, 1.0)
    assert corner[:2] / corner[2] == pytest.approx((112.0, 107.0), abs=0.5)
    assert found["rmse_after_px"] < 1.0 < found["rmse_before_px"]


def test_a_step_that_is_none_is_bad_input(rover, texture):
    result = rover("register", *texture, "--steps", "clahe,sharpen")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "sharpen" in result.err


def test_pictures_without_features_are_refused(rover, texture, tmp_path):
    plain = tmp_path / "plain.png"
    cv2.imwrite(str(plain), np.full((240, 320), 90, np.uint8))
    result = rover("register", texture[0], plain, "--json")
    found = json.loads(result.out)
    assert (result.code, found["status"], found["homography"]) == (0, "failed", None)
    assert found["reason"]


@pytest.mark.parametrize("metres_per_pixel", [0.005, 0.01, 0.02])
def test_boxes_lie_where_the_spot_is_on_disk(rover, tmp_path, metres_per_pixel):
    """A warm disc 16 cm wide at a known pixel, at three scales."""
    rng = np.random.default_rng(5)
    rows, columns = np.mgrid[0:120, 0:160]
    kelvin = 300.0 + rng.normal(0.0, 0.05, (120, 160))
    kelvin[np.hypot(rows - 50, columns - 90) * metres_per_pixel < 0.08] += 4.0
    file = tmp_path / "ground.png"
    cv2.imwrite(str(file), np.round(kelvin * 100.0).astype(np.uint16))
    result = rover("detect", file, "--metres-per-pixel", metres_per_pixel, "--all", "--json")
    (entry,) = json.loads(result.out)
    assert result.code == 0
    assert entry["image"] == str(file)
    assert set(entry["detections"][0]["p"]) == {"obstacle", "surface", "buried", "background"}
    x, y, w, h = entry["detections"][0]["bbox"]
    assert (x + w / 2, y + h / 2) == pytest.approx((90.0, 50.0), abs=0.03 / metres_per_pixel)
    assert w * metres_per_pixel == pytest.approx(0.16, abs=0.1)


def test_the_threshold_leaves_out_what_is_hardly_a_mine(rover, texture):
    def count(threshold):
        (entry,) = json.loads(
            rover("detect", texture[0], "--metres-per-pixel", "0.01", "--threshold", threshold, "--json").out
        )
        return len(entry["detections"])

    assert count(0.0) >= count(0.5) >= count(1.0)
    assert count(0.0) > count(1.0)


@pytest.mark.parametrize("arguments", [("register", "none.png", "none.png"), ("detect", "none.png")])
def test_a_missing_picture_is_bad_input(rover, arguments):
    more = ("--metres-per-pixel", "0.01") if arguments[0] == "detect" else ()
    result = rover(*arguments, *more)
    assert (result.code, result.out) == (2, "")
    assert "none.png" in result.err
