"""Specification: files of other makers are read, or named for what they are: SEQ, CSQ, DJI's, a JPEG with a tail."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.flir_file import split_frames
from rover.capture.picture import read_picture
from rover.capture.radiometric import read_thermogram
from rover.capture.telemetry import split_telemetry
from rover.errors import BadInput

from companion.tests.capture.flir_sample import counts_of, flir_file, jpeg_with

KELVIN = 280.0 + 0.01 * np.arange(48 * 64.0).reshape(48, 64)


def stored(folder: Path, name: str, content: bytes) -> Path:
    file = folder / name
    file.write_bytes(content)
    return file


def exif_jpeg(make: str, model: str, *more: tuple[int, bytes]) -> bytes:
    """A JPEG whose EXIF names a camera, with further segments (marker, content)."""
    texts = [(tag, text.encode() + b"\0") for tag, text in ((0x010F, make), (0x0110, model))]
    at = 8 + 2 + 12 * len(texts) + 4
    entries, tail = b"", b""
    for tag, text in texts:
        inline = text.ljust(4, b"\0") if len(text) <= 4 else struct.pack("<I", at + len(tail))
        entries += struct.pack("<HHI", tag, 2, len(text)) + inline
        tail += text if len(text) > 4 else b""
    exif = b"Exif\0\0II*\0" + struct.pack("<IH", 8, len(texts)) + entries + bytes(4) + tail
    plain = cv2.imencode(".jpg", np.zeros((8, 8), np.uint8))[1].tobytes()
    segments = [(0xE1, exif), *more]
    return plain[:2] + b"".join(
        bytes((0xFF, marker)) + struct.pack(">H", len(content) + 2) + content for marker, content in segments
    ) + plain[2:]  # fmt: skip


def rover(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rover.cli.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, env={**os.environ, "NO_COLOR": "1"}, check=False)


@pytest.mark.parametrize("payload", ["raw", "png"])
@pytest.mark.parametrize("gap", [0, 5, 4096])
def test_every_frame_of_a_seq_is_read(tmp_path: Path, payload: str, gap: int) -> None:
    frames = [flir_file(counts_of(KELVIN + number), payload, "<") + bytes(gap) for number in range(3)]
    file = stored(tmp_path, "drive.seq", b"".join(frames))
    for number in (1, 2, 3):
        found = read_thermogram(file, number)
        assert (found.frame, found.frames) == (number, 3)
        assert np.abs(found.kelvin - KELVIN - number + 1).max() < 0.05


def test_a_signature_among_the_pixels_begins_no_frame() -> None:
    counts = counts_of(KELVIN)
    counts[10, 10:12] = np.frombuffer(b"FFF\0", "<u2")
    assert len(split_frames(flir_file(counts, "raw", "<"))) == 1


def test_decode_names_every_frame_or_the_one_asked_for(tmp_path: Path) -> None:
    frames = [flir_file(counts_of(KELVIN + 5.0 * number), "raw", "<") for number in range(3)]
    file = str(stored(tmp_path, "drive.seq", b"".join(frames)))
    lines = rover("decode", file).stdout.splitlines()
    assert [f"frame {number} of 3" in line for number, line in zip((1, 2, 3), lines, strict=True)] == [True] * 3
    first, third = (json.loads(rover("decode", file, "--json", *more).stdout) for more in ((), ("--frame", "3")))
    assert (first["frame"], first["frames"], third["frame"], third["frames"]) == (1, 3, 3, 3)
    assert third["mean_c"] - first["mean_c"] == pytest.approx(10.0, abs=0.1)
    refused = rover("decode", file, "--frame", "4")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr.strip().endswith("drive.seq: no frame 4: it holds 1 to 3")


def test_a_csq_is_named_as_not_supported(tmp_path: Path) -> None:
    content = flir_file(counts_of(KELVIN), "png", "<").replace(b"\x89PNG", b"\xff\xd8\xff\xf7")
    with pytest.raises(BadInput, match=r"JPEG-LS \(CSQ\) are not supported"):
        read_thermogram(stored(tmp_path, "drive.csq", content))


@pytest.mark.parametrize("model", ["ZH20T", "M3T", "M30T", "FLIR"])
@pytest.mark.parametrize("marker", [0xE3, 0xE4])
def test_dji_s_own_files_are_named_with_camera_and_reason(tmp_path: Path, model: str, marker: int) -> None:
    file = stored(tmp_path, "DJI_0001_R.JPG", exif_jpeg("DJI", model, (marker, bytes(500))))
    with pytest.raises(BadInput, match=f"DJI_0001_R.JPG: DJI {model}: its thermal record is DJI's own"):
        read_thermogram(file)


def test_a_photograph_is_named_with_its_camera_too(tmp_path: Path) -> None:
    file = stored(tmp_path, "photo.jpg", exif_jpeg("NIKON", "Z 6"))
    with pytest.raises(BadInput, match="a JPEG of NIKON Z 6 without FLIR's thermal record"):
        read_thermogram(file)


@pytest.mark.parametrize("tail", [b"\0" * 100, b"\xff\xda\xff\xda", b"\xff\xd8\xff\xda more", b"\xff" * 40])
def test_bytes_behind_a_jpeg_s_end_are_none_of_its_own(tmp_path: Path, tail: bytes) -> None:
    whole = jpeg_with(flir_file(counts_of(KELVIN), "raw", "<"))
    assert np.abs(read_thermogram(stored(tmp_path, "a.jpg", whole + tail)).kelvin - KELVIN).max() < 0.05


@pytest.mark.parametrize("missing", [1, 2, 40])
def test_a_jpeg_without_its_end_is_cut_whatever_its_thumbnail_ends_with(tmp_path: Path, missing: int) -> None:
    whole = jpeg_with(flir_file(counts_of(KELVIN), "raw", "<"))
    file = stored(tmp_path, "a.jpg", whole[:-missing])
    with pytest.raises(BadInput, match=r"a\.jpg: (damaged or )?cut JPEG"):
        read_thermogram(file)


def test_a_radiometric_jpeg_is_read_by_its_temperatures_and_not_by_its_preview(tmp_path: Path) -> None:
    picture = read_picture(stored(tmp_path, "a.jpg", jpeg_with(flir_file(counts_of(KELVIN), "raw", "<"))))
    assert picture.dtype == np.uint16
    assert picture.shape == KELVIN.shape
    assert np.abs(0.01 * picture - KELVIN).max() < 0.06


def telemetry_picture(uptime_ms: int, ffc_ms: int) -> NDArray[np.uint16]:
    words = np.zeros(320, np.uint16)
    words[0], words[24] = 0x0E0E, 30515
    for at, value in ((1, uptime_ms), (3, 3 << 4), (20, 300), (30, ffc_ms)):
        words[at], words[at + 1] = value & 0xFFFF, value >> 16
    return np.vstack((np.full((120, 160), 30_000, np.uint16), words.reshape(2, 160)))


@pytest.mark.parametrize("since_ms", [1_000, 60_000, 3_600_000])
@pytest.mark.parametrize("uptime_ms", [500, 59_000])
def test_an_uptime_that_began_anew_after_49_days_is_still_telemetry(since_ms: int, uptime_ms: int) -> None:
    _, telemetry = split_telemetry(telemetry_picture(uptime_ms, (uptime_ms - since_ms) % 2**32))
    assert telemetry is not None
    assert telemetry.since_ffc == pytest.approx(1e-3 * since_ms)


def test_a_correction_that_lies_ahead_is_no_telemetry() -> None:
    _, telemetry = split_telemetry(telemetry_picture(60_000, 90_000))
    assert telemetry is None
