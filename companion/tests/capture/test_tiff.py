"""Specification: the whole picture of a TIFF is read, its numbers mean what the file says, or one line says why not."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.capture.picture import read_picture, read_picture_of_many
from rover.capture.radiometric import read_thermogram
from rover.errors import BadInput

from companion.tests.capture.tiff_sample import Leaf, Order, tiff

ROWS, COLUMNS = 24, 32
KELVIN = (290.0 + 0.02 * np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS)).astype(np.float32)
CENTIKELVIN = np.round(100.0 * KELVIN).astype(np.uint16)
THUMBNAIL = np.full((6, 8), 128, np.uint8)


def stored(folder: Path, content: bytes) -> Path:
    file = folder / "picture.tif"
    file.write_bytes(content)
    return file


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
@pytest.mark.parametrize(("compression", "predictor"), [(1, 1), (8, 1), (8, 3), (32946, 3)])
@pytest.mark.parametrize("offset", [0.0, 273.15])
def test_floating_point_is_read_as_kelvin_or_celsius(
    tmp_path: Path, order: Order, kind: type[np.floating], compression: int, predictor: int, offset: float
) -> None:
    values = (KELVIN - offset).astype(kind)
    content = tiff(Leaf(values, compression=compression, predictor=predictor, rows_per_strip=7), order=order)
    found = read_thermogram(stored(tmp_path, content)).kelvin
    np.testing.assert_allclose(found, KELVIN, atol=0.13 if kind is np.float16 else 1e-3)
    assert read_picture(tmp_path / "picture.tif").dtype == np.uint16


def test_what_is_no_temperature_in_floating_point_stays_unknown(tmp_path: Path) -> None:
    values = KELVIN - np.float32(273.15)
    values[0, :3] = np.nan, np.inf, -np.inf
    found = read_thermogram(stored(tmp_path, tiff(Leaf(values)))).kelvin
    assert np.isnan(found[0, :3]).all()
    assert np.isfinite(found).sum() == found.size - 3


@pytest.mark.parametrize("value", [1e6, 0.0, -500.0, 180.0])
def test_floating_point_that_is_neither_kelvin_nor_celsius_is_refused(tmp_path: Path, value: float) -> None:
    values = np.full((ROWS, COLUMNS), value, np.float32)
    if value == 0.0:  # 0 °C outdoors is as good as any
        assert read_thermogram(stored(tmp_path, tiff(Leaf(values)))).kelvin[0, 0] == pytest.approx(273.15)
        return
    with pytest.raises(BadInput, match="neither kelvin nor °C"):
        read_thermogram(stored(tmp_path, tiff(Leaf(values))))


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("compression", "predictor"), [(1, 1), (8, 1), (8, 2), (32946, 2)])
def test_sixteen_bits_are_unpacked_exactly(tmp_path: Path, order: Order, compression: int, predictor: int) -> None:
    page = Leaf(CENTIKELVIN, compression=compression, predictor=predictor, rows_per_strip=5)
    assert (read_picture(stored(tmp_path, tiff(page, order=order))) == CENTIKELVIN).all()


@pytest.mark.parametrize(
    "content",
    [
        tiff(Leaf(THUMBNAIL, 1), Leaf(CENTIKELVIN)),
        tiff(Leaf(CENTIKELVIN[::4, ::4], 1), Leaf(CENTIKELVIN, 0)),
        tiff(Leaf(THUMBNAIL), Leaf(CENTIKELVIN)),  # and does not say that it is one
        tiff(Leaf(CENTIKELVIN), Leaf(THUMBNAIL, 1)),
        tiff(Leaf(THUMBNAIL, 1, sub=[Leaf(CENTIKELVIN)])),
        tiff(Leaf(CENTIKELVIN, sub=[Leaf(THUMBNAIL, 1)])),
        tiff(Leaf(np.zeros((ROWS, COLUMNS), np.uint8), 4), Leaf(CENTIKELVIN)),  # a mask of the same size
    ],
)
def test_the_whole_picture_is_taken_and_not_its_thumbnail(tmp_path: Path, content: bytes) -> None:
    picture, frames = read_picture_of_many(stored(tmp_path, content))
    assert frames == 1
    assert (picture == CENTIKELVIN).all()


def test_every_page_is_a_frame(tmp_path: Path) -> None:
    file = stored(tmp_path, tiff(*(Leaf(CENTIKELVIN + np.uint16(100 * number)) for number in range(3))))
    for number in (1, 2, 3):
        thermogram = read_thermogram(file, number)
        assert (thermogram.frame, thermogram.frames) == (number, 3)
        np.testing.assert_allclose(thermogram.kelvin, KELVIN + number - 1, atol=0.006)
    with pytest.raises(BadInput, match="no frame 4: it holds 1 to 3"):
        read_thermogram(file, 4)


def test_directories_that_lead_in_a_circle_end(tmp_path: Path) -> None:
    content = bytearray(tiff(Leaf(CENTIKELVIN)))
    content[-4:] = content[4:8]
    assert read_thermogram(stored(tmp_path, bytes(content))).frames == 1


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (tiff(Leaf(np.dstack([CENTIKELVIN] * 2))), "a TIFF of 2 bands of 16 bits: one band is expected"),
        (tiff(Leaf(np.dstack([CENTIKELVIN] * 7))), "a TIFF of 7 bands of 16 bits"),
        (tiff(Leaf(CENTIKELVIN.astype(np.int16))), "16-bit signed pixels"),
        (tiff(Leaf(CENTIKELVIN.astype(np.uint32))), "32-bit unsigned pixels"),
        (tiff(Leaf(CENTIKELVIN, compression=50_000)), "a TIFF with ZSTD compression is not supported"),
        (tiff(Leaf(CENTIKELVIN, compression=34_887)), "a TIFF with LERC compression is not supported"),
        (tiff(Leaf(CENTIKELVIN, compression=5)), "damaged or cut TIFF: its pixels cannot be unpacked"),
        (tiff(Leaf(CENTIKELVIN, compression=8))[:900], "damaged or cut TIFF"),
        (b"II*\0\x08\0\0\0", "damaged or cut TIFF"),
        (b"II*\0\0\0\0\0", "a TIFF without a picture in it"),
    ],
)
def test_what_cannot_be_read_is_one_true_line_and_nothing_else(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], content: bytes, complaint: str
) -> None:
    file = stored(tmp_path, content)
    for read in (read_picture, read_thermogram):
        with pytest.raises(BadInput) as refused:
            read(file)
        assert str(refused.value).startswith(f"{file}: {complaint}")
        assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("ending", [".png", ".jpg", ".tiff", ".bmp", ".pgm"])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_libraries_print_nothing_about_a_cut_picture(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], ending: str, share: float
) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (60, 80)).astype(np.uint8)
    content = cv2.imencode(ending, noise)[1].tobytes()
    file = tmp_path / f"cut{ending}"
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(BadInput, match=f"cut{ending}: "):
        read_picture(file)
    assert capfd.readouterr() == ("", "")


def test_a_jpeg_with_spoiled_pixels_prints_nothing_either(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (200, 300)).astype(np.uint8)
    content = bytearray(cv2.imencode(".jpg", noise)[1].tobytes())
    content[len(content) // 2 : len(content) // 2 + 400] = bytes(400)
    file = tmp_path / "spoiled.jpg"
    file.write_bytes(content)
    picture: NDArray[np.generic] = read_picture(file)
    assert picture.shape == (200, 300)
    assert capfd.readouterr() == ("", "")


def test_a_folder_is_called_a_folder(tmp_path: Path) -> None:
    for read in (read_picture, read_thermogram):
        with pytest.raises(BadInput, match="a folder, where a"):
            read(tmp_path)
