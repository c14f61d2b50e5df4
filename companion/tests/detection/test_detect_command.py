"""Specification: `rover detect` on real files: 8 and 16 bits, with and without a scale, and one line for each fault."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.cli.main import invoke
from rover.vision.camera.file import load_camera


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of `rover detect`."""
    code = invoke(["detect", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def ground(width: int = 320, height: int = 240, x: float = 200.0, y: float = 90.0) -> np.ndarray:
    """Grey levels of soil with one bright disc of 36 pixels at (x, y)."""
    noise = np.random.default_rng(4).normal(0.0, 1.0, (height, width)).astype(np.float32)
    rows, columns = np.mgrid[0:height, 0:width]
    grey = 110.0 + 8.0 * noise + 20.0 * cv2.GaussianBlur(noise, (0, 0), 5.0)
    grey[np.hypot(columns - x, rows - y) < 18.0] = 225.0
    return np.clip(grey, 0, 255)


def is_at(box: list[float], x: float, y: float) -> bool:
    return abs(box[0] + box[2] / 2 - x) < 8.0 and abs(box[1] + box[3] / 2 - y) < 8.0


def test_an_8_bit_picture_without_a_scale_is_searched(capsys, tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    cv2.imwrite(str(file), ground().astype(np.uint8))
    code, out, _ = run(capsys, file, "--json")
    (entry,) = json.loads(out)
    assert code == 0
    assert any(is_at(d["bbox"], 200, 90) for d in entry["detections"])
    for x, y, w, h in (d["bbox"] for d in entry["detections"]):
        assert 0 <= x <= x + w <= 320
        assert 0 <= y <= y + h <= 240


def entries(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict[str, Any]]:
    """The detections of one picture."""
    return json.loads(run(capsys, *arguments, "--json")[1])[0]["detections"]


def mine_probability(found: dict[str, Any]) -> float:
    return found["p"]["surface"] + found["p"]["buried"]


@pytest.mark.parametrize("camera", [(), ("--metres-per-pixel", "0.01")])
def test_the_threshold_decides_what_is_a_mine(capsys, tmp_path: Path, camera: tuple[str, ...]) -> None:
    file = tmp_path / "a.png"
    cv2.imwrite(str(file), (30_000 + 3.0 * ground()).astype(np.uint16))
    every = entries(capsys, file, *camera, "--all")
    before = every
    for threshold in (0.0, 0.05, 0.3, 0.7, 1.0):
        mines = entries(capsys, file, *camera, "--threshold", threshold)
        assert all(found["class"] in ("surface", "buried") for found in mines)
        assert all(mine_probability(found) >= threshold for found in mines)
        boxes = [found["bbox"] for found in mines]
        assert all(box in [found["bbox"] for found in before] for box in boxes), "more are found at a lower threshold"
        shown = entries(capsys, file, *camera, "--threshold", threshold, "--all")
        assert [found["bbox"] for found in shown] == [found["bbox"] for found in every]
        assert [found for found in shown if found["class"] in ("surface", "buried")] == mines
        before = mines
    assert len(entries(capsys, file, *camera)) < len(every)


def test_a_16_bit_picture_without_a_scale_is_searched_too(capsys, tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    cv2.imwrite(str(file), (30_000 + 3.0 * ground()).astype(np.uint16))
    _, out, _ = run(capsys, file, "--json")
    assert any(is_at(d["bbox"], 200, 90) for d in json.loads(out)[0]["detections"])


def test_boxes_are_in_pixels_on_disk_whatever_the_orientation_tag_says(capsys, tmp_path: Path) -> None:
    ok, jpeg = cv2.imencode(".jpg", ground().astype(np.uint8))
    assert ok
    # Exif with one entry: orientation 6, to be turned by a quarter when shown.
    tiff = b"MM\x00\x2a\x00\x00\x00\x08\x00\x01\x01\x12\x00\x03\x00\x00\x00\x01\x00\x06\x00\x00\x00\x00\x00\x00"
    exif = b"Exif\x00\x00" + tiff
    content = jpeg.tobytes()
    plain, turned = tmp_path / "plain.jpg", tmp_path / "turned.jpg"
    plain.write_bytes(content)
    turned.write_bytes(content[:2] + b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif + content[2:])
    _, out, _ = run(capsys, plain, turned, "--json")
    first, second = json.loads(out)
    assert first["detections"] == second["detections"]
    assert any(is_at(d["bbox"], 200, 90) for d in second["detections"])


def test_a_frame_of_a_mounted_camera_is_told_in_its_own_pixels(capsys, tmp_path: Path) -> None:
    camera = load_camera("lepton-160")
    there = camera.ground_lookup
    spot = np.hypot(there[..., 0] - 0.6, there[..., 1] - 0.1) < 0.05
    noise = np.random.default_rng(1).normal(0.0, 0.05, spot.shape)
    file = tmp_path / "frame.png"
    cv2.imwrite(str(file), np.round((300.0 + 4.0 * spot + noise) * 100.0).astype(np.uint16))
    code, out, _ = run(capsys, file, "--camera", "lepton-160", "--json")
    u, v = camera.ground_to_pixel(np.array([[0.6, 0.1]]))[0]
    assert code == 0
    assert any(is_at(d["bbox"], u, v) for d in json.loads(out)[0]["detections"])


def faulty(folder: Path) -> dict[str, Path]:
    """Files of every fault, by its name."""
    pictures: dict[str, NDArray[np.integer]] = {
        "blank": np.full((120, 160), 30_000, np.uint16),
        "saturated": np.full((120, 160), 65_535, np.uint16),
        "8-bit picture": ground(160, 120, 80, 60).astype(np.uint8),
        "wrong size": (30_000 + ground()).astype(np.uint16),
    }
    files = {}
    for name, picture in pictures.items():
        files[name] = folder / f"{name.replace(' ', '_')}.png"
        cv2.imwrite(str(files[name]), picture)
    files["not a readable picture"] = folder / "corrupt.png"
    files["not a readable picture"].write_bytes(files["blank"].read_bytes()[:60])
    return files


@pytest.mark.parametrize("name", ["blank", "saturated", "8-bit picture", "wrong size", "not a readable picture"])
def test_each_fault_is_one_line_with_its_name(capsys, tmp_path: Path, name: str) -> None:
    file = faulty(tmp_path)[name]
    code, out, err = run(capsys, file, "--camera", "lepton-160")
    assert (code, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert file.name in err
    assert name in err


def test_good_pictures_beside_bad_ones_are_still_searched(capsys, tmp_path: Path) -> None:
    good = tmp_path / "good.png"
    cv2.imwrite(str(good), ground().astype(np.uint8))
    bad = tmp_path / "bad.png"
    cv2.imwrite(str(bad), np.full((240, 320), 90, np.uint8))
    code, out, err = run(capsys, bad, good, "--json")
    first, second = json.loads(out)
    assert code == 2
    assert "blank" in first["error"]
    assert "bad.png: blank" in err
    assert second["detections"]


def test_two_scales_are_one_too_many(capsys, tmp_path: Path) -> None:
    code, _, err = run(capsys, tmp_path / "a.png", "--camera", "lepton-160", "--metres-per-pixel", "0.01")
    assert code == 2
    assert "only one of them" in err
