"""Radiometric files become temperatures, the same as another decoder finds; damaged ones become one clear line."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.capture.radiometric import read_thermogram, spikes
from rover.capture.radiometry import Surroundings
from rover.errors import BadInput

from companion.tests.capture.flir_sample import MODEL, counts_of, flir_file, jpeg_with

KELVIN = np.linspace(280.0, 310.0, 48 * 64).reshape(48, 64)


def decode(tmp_path: Path, data: bytes, name: str = "picture.jpg"):
    file = tmp_path / name
    file.write_bytes(data)
    return read_thermogram(file)


@pytest.mark.parametrize("payload", ["raw", "raw-swapped", "png", "png-swapped"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("record_order", ["<", ">"])
def test_every_layout_gives_the_temperatures_that_went_in(tmp_path, payload, order, record_order):
    found = decode(tmp_path, jpeg_with(flir_file(counts_of(KELVIN), payload, order, record_order)))
    assert found.camera == MODEL
    assert np.abs(found.kelvin - KELVIN).max() < 0.05


def test_an_fff_file_alone_is_read_too(tmp_path):
    found = decode(tmp_path, flir_file(counts_of(KELVIN), "raw", "<"), "picture.fff")
    assert np.abs(found.kelvin - KELVIN).max() < 0.05


def test_emissivity_is_undone_against_the_reflected_temperature(tmp_path):
    """Half black body at T, half mirror of 293.15 K surroundings at no distance: the mean of both counts."""
    seen = (counts_of(KELVIN).astype(float) + counts_of(np.full_like(KELVIN, 293.15))) / 2
    found = decode(tmp_path, flir_file(np.rint(seen).astype(np.uint16), "raw", "<", at20=0.5), "picture.fff")
    assert np.abs(found.kelvin - KELVIN).max() < 0.1


def test_air_on_the_way_pulls_towards_its_own_temperature(tmp_path):
    near = decode(tmp_path, flir_file(counts_of(KELVIN), "raw", "<", at24=0.0), "near.fff")
    far = decode(tmp_path, flir_file(counts_of(KELVIN), "raw", "<", at24=50.0), "far.fff")
    contrast = near.kelvin - 293.15
    assert np.all((far.kelvin - 293.15)[contrast > 1] > contrast[contrast > 1])
    assert np.all((far.kelvin - 293.15)[contrast < -1] < contrast[contrast < -1])


@pytest.mark.parametrize("name", ["FLIR_AX8.jpg", "FLIR_B60.jpg", "FLIR_E40.jpg"])
def test_real_files_equal_another_decoder(data_folder, name):
    flyr = pytest.importorskip("flyr")
    file = data_folder / "radiometric" / name
    assert np.abs(read_thermogram(file).kelvin - flyr.unpack(str(file)).kelvin).max() < 0.1


def test_a_real_zenmuse_file_is_plausible(data_folder):
    found = read_thermogram(data_folder / "radiometric" / "DJI_XTR.jpg")
    assert found.kelvin.shape == (512, 640)
    assert 273.15 < found.kelvin.min() < found.kelvin.max() < 343.15


def damaged(data: bytes, random_source: random.Random):
    for _ in range(150):
        yield data[: random_source.randrange(len(data))]
    for _ in range(300):
        changed = bytearray(data)
        for _ in range(random_source.choice((1, 4, 64))):
            changed[random_source.randrange(len(data))] ^= 1 << random_source.randrange(8)
        yield bytes(changed)


@pytest.mark.parametrize("payload", ["raw", "png"])
def test_damage_is_decoded_or_named_and_never_a_traceback(tmp_path, payload):
    whole = jpeg_with(flir_file(counts_of(KELVIN), payload, ">"))
    complaints = []
    for data in damaged(whole, random.Random(1)):
        try:
            decode(tmp_path, data)
        except BadInput as error:
            complaints.append(str(error))
    assert len(complaints) > 100
    assert all("picture.jpg" in line and "\n" not in line for line in complaints)


def test_a_file_cut_after_its_thermal_record_is_refused_too(tmp_path):
    whole = jpeg_with(flir_file(counts_of(KELVIN), "raw", ">"))
    with pytest.raises(BadInput, match="its end is missing"):
        decode(tmp_path, whole[:-3])


def test_a_flipped_bit_in_a_compressed_payload_is_noticed(tmp_path):
    whole = bytearray(jpeg_with(flir_file(counts_of(KELVIN), "png", ">")))
    whole[whole.index(b"IDAT") + 200] ^= 1
    with pytest.raises(BadInput, match="wrong CRC"):
        decode(tmp_path, bytes(whole))


def test_a_flipped_high_bit_in_an_uncompressed_payload_is_noticed_by_its_pixel(tmp_path):
    counts = counts_of(KELVIN)
    decode(tmp_path, jpeg_with(flir_file(counts, "raw", "<")))
    counts[20, 30] ^= 1 << 14
    with pytest.raises(BadInput, match="1 pixels far off all"):
        decode(tmp_path, jpeg_with(flir_file(counts, "raw", "<")))


def test_a_hot_spot_as_a_lens_draws_it_is_no_damage():
    spot = np.full((48, 64), 290.0, np.float32)
    spot[20, 30] = 900.0
    assert spikes(spot) == 1
    assert spikes(cv2.GaussianBlur(spot, (0, 0), 0.6)) == 0


def test_a_missing_part_of_the_record_is_named(tmp_path):
    record = flir_file(counts_of(KELVIN), "raw", ">")
    data = jpeg_with(record)
    cut = data.find(b"FLIR\0\1\x01")
    with pytest.raises(BadInput, match="parts 1 of 2"):
        decode(tmp_path, data[: cut - 4] + data[cut - 4 + 2 + int.from_bytes(data[cut - 2 : cut], "big") :])


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "empty"),
        (b"temperature;21.5\n" * 30, "not a readable picture"),
        (b"\xff\xd8", "damaged or cut"),
        (cv2.imencode(".jpg", np.zeros((9, 9), np.uint8))[1].tobytes(), "not a radiometric file"),
        (cv2.imencode(".png", np.zeros((9, 9), np.uint8))[1].tobytes(), "8-bit"),
        (cv2.imencode(".png", np.full((9, 9), 4000, np.uint16))[1].tobytes(), "not kelvin"),
    ],
)
def test_what_is_not_radiometric_is_told_apart(tmp_path, data, says):
    with pytest.raises(BadInput, match=says):
        decode(tmp_path, data)


def rover(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rover.cli.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, env={**os.environ, "NO_COLOR": "1"})


def test_the_command_prints_the_contract_and_writes_what_other_commands_read(tmp_path):
    file, tiff = tmp_path / "picture.jpg", tmp_path / "out.tiff"
    file.write_bytes(jpeg_with(flir_file(counts_of(KELVIN), "png-swapped", ">")))
    done = rover("decode", str(file), "--json", "--tiff", str(tiff))
    found = json.loads(done.stdout)
    assert list(found) == ["camera", "width", "height", "min_c", "max_c", "mean_c", "centre_c", "frame", "frames"]
    assert (found["width"], found["height"]) == (64, 48)
    assert found["min_c"] == pytest.approx(6.85, abs=0.05)
    counts = cv2.imread(str(tiff), cv2.IMREAD_UNCHANGED)
    assert counts.dtype == np.uint16
    assert json.loads(rover("decode", str(tiff), "--json").stdout)["max_c"] == pytest.approx(found["max_c"], abs=0.01)


def test_the_command_says_in_one_line_what_is_wrong(tmp_path):
    file = tmp_path / "note.jpg"
    file.write_text("hello")
    done = rover("decode", str(file))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "note.jpg" in done.stderr


def test_what_the_camera_did_not_know_can_be_told(data_folder: Path) -> None:
    file = data_folder / "radiometric/FLIR_E40.jpg"
    as_stored, darker, nearer = (
        float(np.nanmedian(read_thermogram(file, 1, told).kelvin))
        for told in (Surroundings(), Surroundings(emissivity=0.6, reflected=233.15), Surroundings(distance=0.0))
    )
    assert darker > as_stored + 1.0  # less of what arrives was the object's own cold sky, so the object is warmer
    assert nearer != as_stored


def test_what_is_told_must_be_possible_and_of_use(data_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="--humidity 40"):
        read_thermogram(data_folder / "radiometric/FLIR_E40.jpg", 1, Surroundings(humidity=40.0))
    counts = tmp_path / "counts.png"
    cv2.imwrite(str(counts), np.full((20, 30), 29300, np.uint16))
    with pytest.raises(BadInput, match="temperatures already"):
        read_thermogram(counts, 1, Surroundings(emissivity=0.9))
