"""`rover capture`, and sources wherever a command takes pictures."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.capture.picture import read_picture
from rover.cli.main import invoke
from rover.record.recording import Recording


def scene(shift: int) -> np.ndarray:
    rng = np.random.default_rng(4)
    ground = cv2.GaussianBlur(rng.normal(0.0, 1.0, (160, 260)).astype(np.float32), (0, 0), 2.0)
    view = ground[20:140, 20 + shift : 180 + shift] / ground.std() * 200.0 + 29500.0
    return np.rint(view + rng.normal(0.0, 2.0, view.shape)).astype(np.uint16)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Five pictures of ground that moves by 4 px each."""
    file = tmp_path / "log.mcap"
    with Recording(file) as recording:
        for number in range(5):
            recording.frame(0.1 * number, Frame(scene(4 * number), 0.1 * number, number))
    return file


def test_what_is_saved_is_what_the_source_gives(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "frames"
    assert invoke(["capture", str(log), "--out", str(out), "--count", "3", "--preview", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["frames"], found["out"]) == (3, str(out))
    assert sorted(file.name for file in out.glob("*.png")) == ["000001.png", "000002.png", "000003.png"]
    np.testing.assert_array_equal(cv2.imread(str(out / "000002.png"), cv2.IMREAD_UNCHANGED), scene(4))
    preview = read_picture(out / "preview/000002.png")
    assert preview.dtype == np.uint8
    assert preview.std() > 30.0


def test_nothing_is_overwritten_and_nothing_is_made_in_vain(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    held = tmp_path / "held"
    held.mkdir()
    (held / "mine.txt").write_text("mine")
    assert invoke(["capture", str(log), "--out", str(held)]) == 2
    assert "holds something" in capsys.readouterr().err
    assert invoke(["capture", str(tmp_path / "no.mcap"), "--out", str(tmp_path / "new")]) == 2
    assert not (tmp_path / "new").exists()


def test_a_source_stands_wherever_pictures_do(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert invoke(["register", str(log), f"{log}?skip=2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["homography"][0][2] == pytest.approx(-8.0, abs=0.2)
    assert invoke(["stitch", f"mcap:{log}?skip=1&count=3", "--out", str(tmp_path / "m.png"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["width"] == pytest.approx(168, abs=1)
    assert invoke(["grid", f"{log}?count=2", "--out", str(tmp_path / "g.yaml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["width"] == 160
    assert invoke(["detect", f"{log}?count=2", "--json"]) == 0
    assert [entry["image"] for entry in json.loads(capsys.readouterr().out)] == [f"{log}#1", f"{log}#2"]


@pytest.mark.parametrize("steps", ["none", "stretch", "equalizeHist", "fixed-pattern,dead-pixels,gaussian,clahe"])
def test_each_step_can_be_left_out_wherever_pictures_are_registered(
    steps: str, log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m.png"
    assert invoke(["stitch", f"{log}?count=2", "--steps", steps, "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["placed"] == 2
    assert invoke(["track", f"{log}?count=3", "--camera", "lepton-160", "--steps", steps, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tracked"] == 3


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["register", "a.png", "b.png", "--steps", "sharpen"], "'sharpen' is no step"),
        (["stitch", "a.png?count=x", "--out", "m.png"], "a whole number"),
        (["track", "v4l2:0", "--camera", "lepton-160"], "say how many"),
        (["track", "nowhere:x", "--camera", "lepton-160"], "no frame source"),
    ],
)
def test_what_is_no_source_or_step_gets_one_line(
    arguments: list[str], part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert invoke(arguments) == 2
    message = capsys.readouterr().err
    assert part in message
    assert message.count("\n") == 1
