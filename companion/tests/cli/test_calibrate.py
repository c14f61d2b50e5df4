"""`rover calibrate` writes cameras that other commands read, prints one JSON document, and refuses in one line."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.cli.main import invoke
from rover.vision.calibration.board import Board
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel

from companion.tests.vision.calibration_scene import circle_grid, pose, render, staggered_grid, tilted_poses

BOARD = Board(5, 4, 0.05, circles=True)
TRUTH = CameraModel("truth", 160, 120, 150.0, 150.0, 80.5, 59.0)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> list[str]:
    folder = tmp_path_factory.mktemp("board")
    rng = np.random.default_rng(1)
    for number, where in enumerate(tilted_poses(BOARD, TRUTH, 6, rng)):
        cv2.imwrite(str(folder / f"{number}.png"), render(TRUTH, circle_grid(BOARD), where, rng))
    cv2.imwrite(str(folder / "9.png"), np.full((120, 160), 29500, np.uint16))
    return sorted(str(file) for file in folder.iterdir())


def test_a_board_gives_a_camera_file_and_names_pictures_without_one(pictures, tmp_path, capsys):
    out = tmp_path / "camera.toml"
    line = ["calibrate", *pictures, "--board", "5x4", "--square", "0.05", "--circles", "--distortion", "2", "--json"]
    assert invoke([*line, "--name", "mine", "--out", str(out)]) == 0
    streams = capsys.readouterr()
    found = json.loads(streams.out)
    assert found["camera"]["fx"] == pytest.approx(150.0, rel=0.005)
    assert (found["pictures"], len(found["views"])) == (7, 6)
    assert set(found["sigma"]) == {"fx", "fy", "cx", "cy", "k1", "k2"}
    assert "9.png: no board found" in streams.err
    camera = load_camera(out, mounted=False)
    assert (camera.name, camera.width, camera.fx) == ("mine", 160, found["camera"]["fx"])


def test_angles_of_view_give_the_focal_lengths_of_equations_9_and_10(tmp_path, capsys):
    out = tmp_path / "camera.toml"
    assert invoke(["calibrate", "--fov", "45x34", "--size", "320x240", "--json", "--out", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)["camera"]
    assert (found["fx"], found["fy"]) == (pytest.approx(386.27, abs=0.01), pytest.approx(392.50, abs=0.01))
    assert load_camera(out, mounted=False).fx == found["fx"]


def test_points_on_the_ground_complete_the_camera_with_its_mount(tmp_path, capsys):
    truth = load_camera("lepton-160")
    ground = np.array([[x, y] for x in (0.3, 0.6, 1.0) for y in (-0.2, 0.0, 0.2)])
    table = np.column_stack((truth.ground_to_pixel(ground), ground))
    points, out = tmp_path / "points.csv", tmp_path / "camera.toml"
    np.savetxt(points, table, delimiter=",", header="u,v,x,y", comments="", fmt="%.6f")
    assert invoke(["calibrate", "--camera", "lepton-160", "--ground", str(points), "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["mount"]["z_m"] == pytest.approx(0.75, abs=1e-4)
    assert found["mount"]["pitch_deg"] == pytest.approx(52.0, abs=0.01)
    assert load_camera(out).z == pytest.approx(0.75, abs=1e-4)


def test_a_pair_is_calibrated_by_the_board_that_both_see(pictures, tmp_path, capsys):
    camera = tmp_path / "camera.toml"
    camera.write_text("name='c'\nwidth=160\nheight=120\n[intrinsics]\nfx=150.0\nfy=150.0\ncx=80.5\ncy=59.0\n")
    line = ["calibrate", *pictures, "--board", "5x4", "--square", "0.05", "--circles", "--camera", str(camera)]
    folder = str(Path(pictures[0]).parent)
    assert invoke([*line, "--second", folder, "--second-camera", str(camera), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert np.allclose(found["translation_m"], 0.0, atol=1e-6), "the same pictures: the same place"
    assert len(found["views"]) == 6


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ([], "one of --board, --box, --fov or --ground"),
        (["--board", "5x4"], "--square M"),
        (["--board", "5by4", "--square", "0.05"], "two whole numbers with an x"),
        (["--board", "5x4", "--square", "0.05"], "pictures of the board are needed"),
        (["--fov", "45x34"], "--size"),
        (["--fov", "45x340", "--size", "320x240"], "1 to 170 degrees"),
        (["--ground", "none.csv", "--camera", "lepton-160"], "none.csv"),
        (["none.png", "--box", "0.3x0.2"], "none.png: no such picture"),
    ],
)
def test_what_is_missing_is_said_in_one_line(line, says, capsys):
    assert invoke(["calibrate", *line]) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert says in streams.err
    assert streams.err.count("\n") == 1


def test_too_few_pictures_with_a_board_are_refused(pictures, capsys):
    assert invoke(["calibrate", *pictures[-3:], "--board", "5x4", "--square", "0.05", "--circles"]) == 2
    assert "at least 3 are needed" in capsys.readouterr().err


def test_a_staggered_grid_is_told_from_a_square_one_and_a_folder_will_do(tmp_path, capsys):
    board = Board(4, 7, 0.03, circles=True, staggered=True)
    camera = CameraModel("truth", 240, 180, 220.0, 220.0, 119.5, 89.5)
    rng = np.random.default_rng(3)
    folder = tmp_path / "board"
    folder.mkdir()
    middle = tuple((board.points[0, :2] + board.points[-1, :2]) / 2)
    for number in range(5):
        turn = 1.25 * number
        where = pose(middle, 0.42, 0.1, 0.5 * np.cos(turn), 0.5 * np.sin(turn), (0.06 * np.cos(turn), 0.0))
        cv2.imwrite(str(folder / f"{number}.png"), render(camera, staggered_grid(board), where, rng))
    line = ["calibrate", str(folder), "--board", "4x7", "--square", "0.03", "--circles", "--distortion", "0", "--json"]
    assert invoke(line) == 0
    streams = capsys.readouterr()
    found = json.loads(streams.out)
    assert (found["pictures"], len(found["views"])) == (5, 5)
    assert found["camera"]["fx"] == pytest.approx(220.0, rel=0.02)
    assert "staggered" in streams.err
