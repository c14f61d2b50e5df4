"""Files of others that once were read wrongly: each gives the right picture, or one line with the true reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rover.capture import open_source
from rover.capture.picture import read_picture
from rover.capture.radiometric import read_thermogram
from rover.cli.main import invoke
from rover.errors import BadInput

ZERO_C = 273.15


@pytest.fixture
def cases(data_folder: Path) -> Path:
    folder = data_folder / "cases"
    if not folder.is_dir():
        pytest.skip("the folder of real pictures holds no cases")
    return folder


@pytest.mark.parametrize("name", ["f16_kelvin.tif", "subifd.tif", "thumb8_first.tif", "thumb_first.tif"])
def test_the_largest_page_is_read_as_what_it_means(cases: Path, name: str) -> None:
    found = read_thermogram(cases / "12_tiff_half_float_and_thumbnail" / name)
    assert found.kelvin.shape == (120, 160)
    assert float(found.kelvin.mean()) - ZERO_C == pytest.approx(15.7, abs=0.1)
    assert read_picture(cases / "12_tiff_half_float_and_thumbnail" / name).dtype == np.uint16


def test_all_pages_are_read(cases: Path) -> None:
    file = cases / "11_tiff_multipage/multi.tif"
    means = [float(read_thermogram(file, number).kelvin.mean()) - ZERO_C for number in (1, 2, 3)]
    assert means == pytest.approx([15.7, 20.7, 25.7], abs=0.1)
    assert len(list(open_source(str(file)))) == 3


def test_bytes_behind_the_end_do_not_make_a_picture_cut(cases: Path) -> None:
    found = read_thermogram(cases / "14_jpeg_trailer_called_cut/trailer.jpg")
    assert found.camera == "FLIR SC660"
    assert found.kelvin.shape == (480, 640)


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("09_dji_rjpeg_called_non_radiometric/H20T_DJI_0001_R.JPG", "ZH20T: its thermal record is DJI's own"),
        ("09_dji_rjpeg_called_non_radiometric/M3T_DJI_0001_R.JPG", "M3T: its thermal record is DJI's own"),
        ("13_opencv_noise_on_bad_input/two_band.tif", "2 bands of 16 bits"),
        ("13_opencv_noise_on_bad_input/five_band.tif", "5 bands of 16 bits"),
        ("13_opencv_noise_on_bad_input/zstd.tif", "ZSTD"),
        ("13_opencv_noise_on_bad_input/trunc_lzw.tif", "damaged or cut TIFF"),
        ("13_opencv_noise_on_bad_input/trunc.png", "damaged, cut"),
    ],
)
def test_what_cannot_be_read_gets_one_true_line_and_nothing_of_a_library(
    cases: Path, file: str, reason: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(BadInput, match=reason):
        read_thermogram(cases / file)
    assert invoke(["decode", str(cases / file)]) == 2
    written = capfd.readouterr()
    assert written.out == ""
    assert written.err.startswith("rover: ")
    assert written.err.count("\n") == 1
