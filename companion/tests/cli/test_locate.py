"""`rover locate`; what is printed holds no command to a terminal."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from rover.cli.main import invoke
from rover.cli.output import printable


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, float]:
    assert invoke([*arguments, "--json"]) == 0
    found: dict[str, float] = json.loads(capsys.readouterr().out)
    return found


def test_a_pixel_and_its_ground_point_lead_to_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    ground = answer(capsys, "locate", "--camera", "lepton-160", "--pixel", "40,70")
    pixel = answer(capsys, "locate", "--camera", "lepton-160", "--ground", f"{ground['x']},{ground['y']}")
    assert (pixel["u"], pixel["v"]) == pytest.approx((40.0, 70.0), abs=1e-6)
    assert ground["y"] > 0.0  # left of the middle


def test_sigma_is_that_of_a_level_camera_worked_out_by_hand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """1 m high, pitched by 45°: the middle looks 1 m ahead; a pitch off by e moves that by 2 e to first order."""
    camera = tmp_path / "c.toml"
    camera.write_text(
        'name = "c"\nwidth = 161\nheight = 121\n[intrinsics]\nfx = 200.0\nfy = 200.0\n'
        "[mount]\nz_m = 1.0\npitch_deg = 45.0\n"
    )
    found = answer(capsys, "locate", "--camera", str(camera), "--pixel", "80,60", "--sigma-px", "0", "--sigma-deg", "1")
    assert (found["x"], found["y"]) == pytest.approx((1.0, 0.0), abs=1e-9)
    assert found["sigma_x_m"] == pytest.approx(2.0 * math.radians(1.0), rel=1e-4)
    by_pixel = answer(capsys, "locate", "--camera", str(camera), "--pixel", "80,60", "--sigma-px", "1")
    assert by_pixel["sigma_x_m"] == pytest.approx(2.0 / 200.0, rel=1e-4)
    assert by_pixel["sigma_y_m"] == pytest.approx(math.sqrt(2.0) / 200.0, rel=1e-4)


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ([], "one of --pixel"),
        (["--pixel", "1,2", "--ground", "1,2"], "one of --pixel"),
        (["--pixel", "1"], "two numbers"),
        (["--pixel", "nan,2"], "two numbers"),
        (["--pixel", "900,2"], "outside of the picture"),
        (["--ground", "-3,0"], "does not see"),
    ],
)
def test_what_cannot_be_located_gets_one_line(
    options: list[str], part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert invoke(["locate", "--camera", "lepton-160", *options]) == 2
    message = capsys.readouterr().err
    assert part in message
    assert message.count("\n") == 1


def test_nothing_that_is_printed_commands_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert invoke(["decode", "a\x1b[31m\x07\x9b2J\u202eb"]) == 2
    shown = capsys.readouterr().err
    assert "\\u001b[31m\\u0007\\u009b2J\\u202eb" in shown
    assert printable("Grüße\tan\nalle ±1 µm") == "Grüße\tan\nalle ±1 µm"
