"""What a command writes costs neither its own input nor half of the pixels."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest


@pytest.fixture
def pictures(tmp_path: Path) -> list[Path]:
    random = np.random.default_rng(1)
    ground = cv2.GaussianBlur(random.normal(0.0, 1.0, (160, 220)), (0, 0), 2.0)
    counts = (30_000 + 3_000 * ground / np.abs(ground).max()).astype(np.uint16)
    files = []
    for number, left in enumerate((0, 20)):
        files.append(tmp_path / f"{number}.png")
        cv2.imwrite(str(files[-1]), counts[:, left : left + 200])
    return files


def test_a_mosaic_is_not_written_over_a_picture_that_it_is_made_of(rover, pictures: list[Path], tmp_path: Path) -> None:
    before = [file.read_bytes() for file in pictures]
    link = tmp_path / "mosaic.png"
    link.symlink_to(pictures[1])
    for out in (pictures[0], link, tmp_path / "." / "1.png"):
        result = rover("stitch", *pictures, "--out", out)
        assert result.code == 2
        assert f"--out {out}: is" in result.err
    assert [file.read_bytes() for file in pictures] == before


@pytest.mark.parametrize("name", ["mosaic.jpg", "mosaic.JPEG", "mosaic.webp", "mosaic.bmp", "mosaic"])
def test_sixteen_bits_are_not_written_as_eight(rover, pictures: list[Path], tmp_path: Path, name: str) -> None:
    result = rover("stitch", *pictures, "--out", tmp_path / name)
    assert result.code == 2
    assert "does not hold 16 bits: name a .png or .tiff" in result.err
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("name", ["mosaic.png", "mosaic.TIFF"])
def test_a_name_that_holds_them_keeps_them(rover, pictures: list[Path], tmp_path: Path, name: str) -> None:
    result = rover("stitch", *pictures, "--out", tmp_path / name)
    assert result.code == 0, result.err
    written = cv2.imread(str(tmp_path / name), cv2.IMREAD_UNCHANGED)
    assert written is not None
    assert written.dtype == np.uint16


def test_a_camera_is_not_written_over_a_picture(rover, pictures: list[Path]) -> None:
    before = pictures[0].read_bytes()
    for out in (pictures[0], pictures[0].with_name("camera.png")):
        result = rover("calibrate", *pictures, "--board", "5x4", "--square", "0.1", "--out", out)
        assert result.code == 2
        assert f"--out {out}" in result.err
    assert pictures[0].read_bytes() == before


def test_a_camera_is_not_written_over_its_points(rover, tmp_path: Path) -> None:
    points = tmp_path / "points.toml"
    points.write_text("u,v,x,y\n")
    result = rover("calibrate", "--camera", "lepton-160", "--ground", points, "--out", points)
    assert result.code == 2
    assert points.read_text() == "u,v,x,y\n"
