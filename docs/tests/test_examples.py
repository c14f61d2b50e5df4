"""The programs of docs/examples do what they say, and its pictures are those that its script makes."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.testing.served import ServedRig

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(name: str, *arguments: str) -> str:
    """What the program prints; the test fails with what it said when it ends with an error."""
    command = [sys.executable, str(EXAMPLES / name), *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


@pytest.fixture
def firmware() -> None:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))


@pytest.mark.parametrize("program", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_every_program_is_short(program: Path) -> None:
    assert len(program.read_text(encoding="utf-8").splitlines()) < 60


@pytest.mark.rig("sitl")
@pytest.mark.usefixtures("firmware")
def test_the_square_ends_where_it_began() -> None:
    printed = run("drive_square.py")
    x, y, turned = (float(number) for number in re.findall(r"[+-]?\d+\.\d+", printed))
    assert abs(x) < 0.03
    assert abs(y) < 0.03
    assert turned == pytest.approx(1.5 * np.pi, abs=0.05), "three left turns: it ends facing down the last side"


@pytest.mark.rig("sitl")
@pytest.mark.usefixtures("firmware")
def test_a_board_tells_who_it_is_and_how_it_stands() -> None:
    rig = ServedRig("demo", "--free-run", "--no-camera")
    try:
        printed = run("talk_to_board.py", rig.port)
    finally:
        rig.stop()
    assert "on Sitl" in printed
    assert "dead-man after 300 ms" in printed
    assert "state Disarmed, faults: none" in printed
    assert 7.0 < float(re.findall(r"battery ([\d.]+) V", printed)[0]) < 8.4
    assert len(re.findall(r"^sonar (?:left|centre|right): ", printed, re.MULTILINE)) == 3


def test_two_frames_of_a_drive_are_laid_over_each_other(tmp_path: Path) -> None:
    out = tmp_path / "overlay.png"
    frames = EXAMPLES / "frames"
    printed = run("register_pictures.py", str(frames / "00.png"), str(frames / "03.png"), str(out))
    assert float(re.findall(r"([\d.]+) px", printed)[0]) < 2.0
    drawn = cv2.imread(str(out))
    assert drawn is not None
    moved, fixed = drawn[..., 0], drawn[..., 1]
    both = moved > 0  # where the first picture lies over the second
    assert np.count_nonzero(both) > 0.5 * both.size
    assert np.corrcoef(moved[both], fixed[both])[0, 1] > 0.8, "laid over each other, they show the same ground"


def test_the_pictures_are_those_that_the_script_makes(tmp_path: Path) -> None:
    run("make_pictures.py", str(tmp_path))
    made = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*.*"))
    assert made == sorted(path.relative_to(EXAMPLES) for path in EXAMPLES.rglob("*") if path.suffix in (".png", ".jpg"))
    for name in made:
        if name.suffix == ".png":  # how a library packs the bytes is its own affair, the pixels are not
            fresh, kept = (cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED) for folder in (tmp_path, EXAMPLES))
            np.testing.assert_array_equal(fresh, kept)
        else:
            assert (tmp_path / name).stat().st_size == pytest.approx((EXAMPLES / name).stat().st_size, rel=0.1)
