"""Reading pictures from disk as 8 or 16 bits of one channel, with errors that name the file.

A file that knows its temperatures gives these, as kelvin × 100, and not the preview for the eye that it shows as well.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.bounds import read_bounded
from rover.capture.radiometric import has_thermal_record, read_thermogram
from rover.capture.raster import KINDS, decode_raster
from rover.capture.temperatures import as_centikelvin, kelvin_of_floats
from rover.errors import BadInput
from rover.plain_file import plain_file

EXTENSIONS = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".pgm", ".bmp")

# Kinds of pictures that keep 16 bits; others are written with 8, or not at all.
HOLDS_16_BITS = (".png", ".tif", ".tiff")


def files_of(place: Path | str, endings: tuple[str, ...] = EXTENSIONS, kind: str = KINDS) -> list[Path]:
    """A folder's files with one of these endings, by name. Raises BadInput without a folder or a file."""
    folder = Path(place)
    if not plain_file(folder).is_dir():
        raise BadInput(f"{folder}: no such folder of frames")
    files = sorted((f for f in folder.iterdir() if f.suffix.lower() in endings), key=lambda f: f.name)
    if not files:
        raise BadInput(f"{folder}: no {kind} frames in this folder")
    return files


def read_picture(path: Path | str) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """The first picture at `path` as (H, W), its depth kept; colour is turned into grey.

    Temperatures, of a radiometric file or in floating point, become kelvin × 100. Raises BadInput when the file is
    missing, empty, damaged, not a picture, or neither 8 nor 16 bits deep.
    """
    return read_picture_of_many(path)[0]


def read_picture_of_many(
    path: Path | str, frame: int = 1
) -> tuple[NDArray[np.uint8] | NDArray[np.uint16], int]:
    """As `read_picture`, the picture numbered `frame` from 1, and how many the file holds."""
    file = Path(path)
    if file.is_dir():
        raise BadInput(f"{file}: a folder, where a picture is expected")
    if not plain_file(file).is_file():
        raise BadInput(f"{file}: no such picture")
    content = read_bounded(file)
    if has_thermal_record(content):
        thermogram = read_thermogram(file, frame)
        return as_centikelvin(thermogram.kelvin), thermogram.frames
    raster = decode_raster(content, str(file), frame)
    pixels = raster.pixels
    if pixels.dtype == np.uint8:
        return np.asarray(pixels, np.uint8), raster.frames
    if pixels.dtype == np.uint16:
        return np.asarray(pixels, np.uint16), raster.frames
    return as_centikelvin(kelvin_of_floats(pixels, str(file))), raster.frames


def read_counts(path: Path | str) -> NDArray[np.uint16]:
    """The 16-bit thermal picture at `path`, (H, W). Raises BadInput also for an 8-bit picture."""
    image = read_picture(path)
    if image.dtype != np.uint16:
        raise BadInput(f"{path}: 8-bit picture; thermal frames are 16 bits (kelvin × 100)")
    return image.astype(np.uint16, copy=False)


def check_name(path: Path, dtype: np.dtype[Any]) -> None:
    """Raises BadInput for a name whose kind of picture does not hold these pixels as they are."""
    if dtype == np.uint16 and path.suffix.lower() not in HOLDS_16_BITS:
        raise BadInput(f"{path}: {path.suffix or 'no ending'} does not hold 16 bits: name a .png or .tiff")


def write_picture(path: Path, picture: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
    """Writes (H, W) of 8 or 16 bits; the name's ending says how. Raises BadInput when that cannot be done."""
    check_name(path, picture.dtype)
    try:
        done = cv2.imwrite(str(path), picture)
    except cv2.error:
        done = False
    if not done:
        raise BadInput(f"{path}: cannot be written; a name ending in .png or .tiff in an existing folder is expected")
