"""Frames come in order, 16 bits deep, and what is wrong with a file is said in one line that names it."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.capture.picture import read_counts, read_picture
from rover.capture.source import SOURCES, open_source
from rover.errors import BadInput


def counts(seed: int = 0, shape: tuple[int, int] = (12, 16)) -> np.ndarray:
    return np.random.default_rng(seed).integers(28000, 31000, shape).astype(np.uint16)


def test_kelvin_is_a_hundredth_of_the_counts() -> None:
    assert Frame(np.full((2, 3), 29315, np.uint16), 0.0, 0).kelvin() == pytest.approx(293.15)


@pytest.mark.parametrize("bad", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3), np.uint16), np.zeros(4, np.uint16)])
def test_a_frame_of_another_depth_or_shape_is_refused(bad: np.ndarray) -> None:
    with pytest.raises(BadInput, match="16-bit picture of one channel"):
        Frame(bad, 0.0, 3)


def test_folder_yields_every_file_by_name_with_its_16_bits(tmp_path: Path) -> None:
    for index in (2, 0, 1):
        cv2.imwrite(str(tmp_path / f"f{index}.{'tiff' if index == 1 else 'png'}"), counts(index))
    (tmp_path / "notes.txt").write_text("not a frame")
    frames = list(open_source(f"folder:{tmp_path}"))
    assert [f.sequence for f in frames] == [0, 1, 2]
    assert [f.time for f in frames] == pytest.approx([0.0, 0.12, 0.24])
    for index, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.counts, counts(index))


def test_a_frame_of_another_size_names_its_file(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), counts())
    cv2.imwrite(str(tmp_path / "b.png"), counts(shape=(10, 16)))
    with pytest.raises(BadInput, match=r"b\.png: 16×10, the first frame is 16×12"):
        list(open_source(str(tmp_path)))


def test_missing_and_empty_folders_and_unknown_kinds_are_told_apart(tmp_path: Path) -> None:
    for location, message in (
        (str(tmp_path / "none"), "no such folder"),
        (str(tmp_path), "no PNG or TIFF"),
        ("tape:3", "no frame source 'tape'"),
    ):
        with pytest.raises(BadInput, match=message):
            open_source(location)
    assert "folder" in SOURCES


@pytest.mark.parametrize(
    "content", [b"", b"text, not a picture", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, b"II*\0" + b"\xff" * 30]
)
def test_damaged_pictures_give_one_line(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "damaged.png"
    file.write_bytes(content)
    with pytest.raises(BadInput, match=r"damaged\.png: (not a readable picture|damaged or cut TIFF)") as caught:
        read_picture(file)
    assert "\n" not in str(caught.value)


def test_an_8_bit_picture_is_no_thermal_frame(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "grey.png"), np.zeros((8, 8), np.uint8))
    with pytest.raises(BadInput, match="8-bit picture"):
        read_counts(tmp_path / "grey.png")


@pytest.mark.parametrize("order", ["<", ">"])
def test_plain_tiff_without_a_photometric_tag_is_read_in_both_byte_orders(tmp_path: Path, order: str) -> None:
    picture = counts(5)
    body = picture.astype(order + "u2").tobytes()
    tags = [(256, 3, 16), (257, 3, 12), (258, 3, 16), (259, 3, 1), (273, 4, 0), (277, 3, 1), (279, 4, len(body))]
    start = 8 + 2 + 12 * len(tags) + 4
    entries = b""
    for tag, kind, value in tags:
        value = start if tag == 273 else value
        packed = struct.pack(order + ("H" if kind == 3 else "I"), value).ljust(4, b"\0")
        entries += struct.pack(order + "HHI", tag, kind, 1) + packed
    header = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", 8)
    file = tmp_path / "plain.tiff"
    file.write_bytes(header + struct.pack(order + "H", len(tags)) + entries + b"\0\0\0\0" + body)
    np.testing.assert_array_equal(read_picture(file), picture)
    file.write_bytes(file.read_bytes()[:-40])
    with pytest.raises(BadInput):
        read_picture(file)
