"""Specification: `rover decode` gives the temperatures of every kind of source, frame by frame."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.cli.main import invoke

from companion.tests.capture.cptv_sample import cptv_clip
from companion.tests.capture.flir_sample import counts_of, flir_file

# Kelvin × 100, of another mean in each frame.
FRAMES = [(29_000 + 100 * k + np.arange(12 * 16) % 7).reshape(12, 16).astype(np.uint16) for k in range(3)]
MEANS = [float(frame.mean()) / 100.0 - 273.15 for frame in FRAMES]


def decoded(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = invoke(["decode", *arguments])
    told = capsys.readouterr()
    return code, told.out, told.err


@pytest.fixture(params=["cptv", "folder", "seq", "pages"])
def source(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "cptv":
        clip = tmp_path / "clip.cptv"
        clip.write_bytes(cptv_clip(FRAMES))
        return f"{clip}?unit=centikelvin"
    if request.param == "seq":
        file = tmp_path / "drive.seq"
        kelvin = [frame.astype(np.float64) / 100.0 for frame in FRAMES]
        file.write_bytes(b"".join(flir_file(counts_of(k), "raw", "<") for k in kelvin))
        return str(file)
    if request.param == "pages":
        file = tmp_path / "pages.tiff"
        assert cv2.imwritemulti(str(file), FRAMES)
        return str(file)
    for number, frame in enumerate(FRAMES):
        cv2.imwrite(str(tmp_path / f"{number}.tiff"), frame)
    return str(tmp_path)


def test_every_frame_of_every_kind_of_source_is_named(source: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = decoded(capsys, source)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert len(lines) == 3
    for number, (line, mean) in enumerate(zip(lines, MEANS, strict=True), 1):
        assert f"frame {number} of 3" in line
        assert float(line.partition("mean ")[2].partition(" ")[0]) == pytest.approx(mean, abs=0.05)


def test_one_frame_is_chosen_by_its_number(source: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out_file = tmp_path.parent / f"{tmp_path.name}.tiff"
    code, out, _ = decoded(capsys, source, "--frame", "2", "--json", "--tiff", str(out_file))
    found = json.loads(out)
    assert (code, found["frame"], found["frames"]) == (0, 2, 3)
    assert found["mean_c"] == pytest.approx(MEANS[1], abs=0.05)
    written = cv2.imread(str(out_file), cv2.IMREAD_UNCHANGED)
    assert written is not None
    assert np.abs(written.astype(int) - FRAMES[1]).max() <= 5


def test_a_frame_that_is_not_there_is_one_line(source: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = decoded(capsys, source, "--frame", "4")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert err.strip().endswith("no frame 4: it holds 1 to 3")


def test_raw_counts_of_a_clip_are_named_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = tmp_path / "raw.cptv"
    clip.write_bytes(cptv_clip([frame - np.uint16(26_000) for frame in FRAMES]))
    for place, reason in ((str(clip), "are no temperatures"), (f"{clip}?unit=centikelvin", "counts that are not temp")):
        code, out, err = decoded(capsys, place)
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert reason in err


def test_what_a_source_says_is_not_changed_by_an_emissivity(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = tmp_path / "clip.cptv"
    clip.write_bytes(cptv_clip(FRAMES))
    code, _, err = decoded(capsys, f"{clip}?unit=centikelvin", "--emissivity", "0.9")
    assert code == 2
    assert "temperatures already" in err


def test_the_picture_that_is_decoded_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.tiff"
    cv2.imwrite(str(file), FRAMES[0])
    before = file.read_bytes()
    code, _, err = decoded(capsys, str(file), "--tiff", str(file))
    assert code == 2
    assert "--tiff" in err
    assert file.read_bytes() == before
