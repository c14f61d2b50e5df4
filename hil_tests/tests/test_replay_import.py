"""A folder of frames and CSV files, as a person records them, becomes a log whose replay is equal to the import."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from rover.cli.main import invoke

FRAMES = 12
PERIOD = 0.12
# A person's clock counts from anywhere.
UNIX = 1_700_000_000.0


def write_rows(file: Path, rows: list[dict[str, Any]]) -> None:
    with file.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Synthetic: textured ground that does not move, wheels that stand, one sensor that sees something."""
    made = tmp_path / "stream"
    (made / "pictures").mkdir(parents=True)
    rng = np.random.default_rng(4)
    ground = cv2.GaussianBlur(rng.normal(29_800.0, 400.0, (120, 160)), (0, 0), 2.0)
    frames = []
    for index in range(FRAMES):
        counts = (ground + rng.normal(0.0, 3.0, ground.shape)).astype(np.uint16)
        cv2.imwrite(str(made / "pictures" / f"{index:04}.png"), counts)
        frames.append({"time_s": UNIX + index * PERIOD, "file": f"pictures/{index:04}.png", "ffc": int(index == 5)})
    write_rows(made / "frames.csv", frames)
    wheels = [{"time_s": UNIX + t * 0.02, "left_counts": 0, "right_counts": 0} for t in range(80)]
    write_rows(made / "wheels.csv", wheels)
    names = ("left", "centre", "right")
    sonar = [{"time_s": UNIX + t * 0.1, "sensor": names[t % 3], "range_m": "" if t % 3 else "0.8"} for t in range(14)]
    write_rows(made / "sonar.csv", sonar)
    return made


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, Any]:
    code = invoke(list(arguments))
    out = capsys.readouterr().out
    return code, json.loads(out) if out else None


def test_an_imported_folder_replays_identically(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(tmp_path / "stream.mcap")
    code, counts = printed(capsys, "replay", "--import", str(folder), "--out", log, "--json")
    assert code == 0
    assert (counts["frames"], counts["wheel reports"], counts["ranges"]) == (FRAMES, 80, 14)
    code, result = printed(capsys, "replay", log, "--json", "--quiet")
    assert code == 0
    assert (result["frames"], result["identical"], result["first_difference"]) == (FRAMES, True, None)
    assert result["parts"]["companion"]["compared"] >= 2 * FRAMES - 1


def test_another_launch_gives_another_pose_and_the_first_is_named(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(tmp_path / "stream.mcap")
    printed(capsys, "replay", "--import", str(folder), "--out", log, "--json")
    code, result = printed(capsys, "replay", log, "--json", "--override", "launch.x_m=9.5")
    assert code == 6
    difference = result["first_difference"]
    assert (difference["topic"], difference["field"]) == ("/pose", "pose.position.x")
    assert difference["recorded"] == pytest.approx(10.0, abs=0.05)
    assert difference["replayed"] == pytest.approx(9.5, abs=0.05)


def replaced(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("frames.csv", "pictures/0003.png", "pictures/x.png", "frames.csv:5:"),
        ("frames.csv", "time_s,file", "time,file", "no column time_s"),
        ("wheels.csv", ",0,0", ",zero,0", "wheels.csv:2: left_counts: a number is expected"),
        ("sonar.csv", "centre", "middle", "sonar.csv:3: sensor: one of left, centre, right"),
        ("sonar.csv", "0.8", "-0.8", "sonar.csv:2: range_m"),
        ("wheels.csv", f"{UNIX + 0.02}", f"{UNIX - 1}", "times must not go back"),
    ],
)
def test_a_mistake_is_named_with_its_place(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str, old: str, new: str, said: str
) -> None:
    replaced(folder / file, old, new)
    assert invoke(["replay", "--import", str(folder), "--out", str(tmp_path / "x.mcap")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1


def test_without_wheels_it_is_said_what_is_missing(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "wheels.csv").unlink()
    assert invoke(["replay", "--import", str(folder), "--out", str(tmp_path / "x.mcap")]) == 2
    assert "wheels.csv: no such file; columns time_s, left_counts, right_counts" in capsys.readouterr().err
