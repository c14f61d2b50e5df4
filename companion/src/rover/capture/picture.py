"""Reading pictures from disk: 8 or 16 bits, one channel, with errors that name the file."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.tiff import decode_plain_tiff
from rover.errors import BadInput

EXTENSIONS = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".pgm", ".bmp")
KINDS = "PNG, TIFF, JPEG, PGM or BMP"


def files_of(place: Path | str, endings: tuple[str, ...] = EXTENSIONS, kind: str = KINDS) -> list[Path]:
    """A folder's files with one of these endings, by name. Raises BadInput without a folder or a file."""
    folder = Path(place)
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder of frames")
    files = sorted((f for f in folder.iterdir() if f.suffix.lower() in endings), key=lambda f: f.name)
    if not files:
        raise BadInput(f"{folder}: no {kind} frames in this folder")
    return files


def read_picture(path: Path | str) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """The picture at `path` as (H, W), its depth kept; colour is turned into grey.

    Raises BadInput when the file is missing, empty, not a picture, or neither 8 nor 16 bits deep.
    """
    file = Path(path)
    if not file.is_file():
        raise BadInput(f"{file}: no such picture")
    content = file.read_bytes()
    plain = decode_plain_tiff(content)
    if plain is not None:
        return plain
    data = np.frombuffer(content, dtype=np.uint8)
    try:
        image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    except cv2.error:
        image = None
    if image is None:
        raise BadInput(f"{file}: not a readable picture ({KINDS} expected)")
    if image.ndim == 3 and image.shape[2] > 1:
        image = cv2.cvtColor(image[:, :, :3], cv2.COLOR_BGR2GRAY)
    image = image.reshape(image.shape[:2])
    if image.dtype == np.uint16:
        return np.asarray(image, np.uint16)
    if image.dtype == np.uint8:
        return np.asarray(image, np.uint8)
    raise BadInput(f"{file}: {image.dtype} pixels; 8 or 16 bits expected")


def read_counts(path: Path | str) -> NDArray[np.uint16]:
    """The 16-bit thermal picture at `path`, (H, W). Raises BadInput also for an 8-bit picture."""
    image = read_picture(path)
    if image.dtype != np.uint16:
        raise BadInput(f"{path}: 8-bit picture; thermal frames are 16 bits (kelvin × 100)")
    return image.astype(np.uint16, copy=False)


def write_picture(path: Path, picture: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
    """Writes (H, W) of 8 or 16 bits; the name's ending says how. Raises BadInput when that cannot be done."""
    try:
        done = cv2.imwrite(str(path), picture)
    except cv2.error:
        done = False
    if not done:
        raise BadInput(f"{path}: cannot be written; a name ending in .png or .tiff in an existing folder is expected")
