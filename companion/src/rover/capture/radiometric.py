"""Radiometric files to temperatures: FLIR and Zenmuse JPEG, FLIR's own FFF, and 16-bit pictures in kelvin × 100."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rover.capture import exif, flir_file, jpeg_segments
from rover.capture.frame import KELVIN_PER_COUNT
from rover.capture.picture import read_picture, write_picture
from rover.errors import BadInput

# From the coldest sky to the hottest range of any camera of this kind; the median of a picture lies in between.
PLAUSIBLE_KELVIN = (123.0, 2500.0)

# Where a picture must lie whose file does not say what its 16-bit counts mean.
OUTDOORS_KELVIN = (203.0, 423.0)

# How far a single pixel must lie beyond its neighbours, and how many times their own range, to be damage: in pictures
# of four cameras none lies beyond by more than 6 K or by more than its neighbours' range.
SPIKE_KELVIN, SPIKE_RATIO = 30.0, 5.0


@dataclass(frozen=True, eq=False)
class Thermogram:
    """camera: as the file names it. kelvin: (H, W) float32, NaN where the sensor's count means no temperature."""

    camera: str
    kelvin: NDArray[np.float32]


def read_thermogram(path: Path | str) -> Thermogram:
    """Decodes a radiometric file. Raises BadInput, one line, for a file that is missing, damaged or not radiometric."""
    file = Path(path)
    name = str(file)
    if not file.is_file():
        raise BadInput(f"{name}: no such file")
    data = file.read_bytes()
    if not data:
        raise BadInput(f"{name}: the file is empty")
    if data.startswith(flir_file.FILE_SIGNATURE):
        return _of_flir(flir_file.parse(data, name), "", name)
    if data.startswith(jpeg_segments.START_OF_IMAGE):
        parts = list(jpeg_segments.segments(data, name))
        jpeg_segments.check_end(data, name)
        record = flir_file.join_segments(parts, name)
        if record is None:
            raise BadInput(f"{name}: a JPEG without FLIR's thermal record: not a radiometric file")
        return _of_flir(flir_file.parse(record, name), exif.camera_name(parts), name)
    return _of_counts(read_picture(file), name)


def write_counts(path: Path, kelvin: NDArray[np.float32]) -> None:
    """Writes a 16-bit TIFF of kelvin × 100, 0 where there is no temperature. Raises BadInput when it cannot."""
    write_picture(path, as_centikelvin(kelvin))


def as_centikelvin(kelvin: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Temperatures (H, W) as kelvin × 100, 0 where there is none (NaN)."""
    counts = np.nan_to_num(np.rint(kelvin / KELVIN_PER_COUNT), nan=0.0)
    centikelvin: NDArray[np.uint16] = np.clip(counts, 0, 65535).astype(np.uint16)
    return centikelvin


def _of_flir(content: flir_file.FlirFile, camera: str, name: str) -> Thermogram:
    kelvin = content.radiometry.kelvin(content.raw)
    _check_median(kelvin, PLAUSIBLE_KELVIN, f"{name}: damaged thermal record")
    alone = spikes(kelvin)
    if alone:
        raise BadInput(f"{name}: damaged thermal record: {alone} pixels far off all their neighbours")
    return Thermogram(content.model or camera or "unknown", kelvin)


def spikes(kelvin: NDArray[np.float32]) -> int:
    """Number of pixels that lie far beyond all their eight neighbours, which are like each other.

    A lens spreads the smallest and hottest spot over its neighbours; a flipped bit does not. NaN counts for nothing.
    """
    around = np.pad(kelvin, 1, mode="edge")
    height, width = kelvin.shape
    beside = [
        around[row : row + height, column : column + width]
        for row in range(3)
        for column in range(3)
        if (row, column) != (1, 1)
    ]
    lowest, highest = np.minimum.reduce(beside), np.maximum.reduce(beside)
    beyond = np.maximum(kelvin - highest, lowest - kelvin)
    return int(((beyond > SPIKE_KELVIN) & (beyond > SPIKE_RATIO * (highest - lowest))).sum())


def _of_counts(picture: NDArray[np.uint8] | NDArray[np.uint16], name: str) -> Thermogram:
    if picture.dtype != np.uint16:
        raise BadInput(f"{name}: an 8-bit picture: not a radiometric file")
    kelvin = picture.astype(np.float32) * np.float32(KELVIN_PER_COUNT)
    _check_median(kelvin, OUTDOORS_KELVIN, f"{name}: 16-bit counts that are not kelvin × 100")
    return Thermogram("unknown", kelvin)


def _check_median(kelvin: NDArray[np.float32], limits: tuple[float, float], complaint: str) -> None:
    known = kelvin[np.isfinite(kelvin)]
    median = float(np.median(known)) if known.size > kelvin.size // 2 else float("nan")
    if not limits[0] <= median <= limits[1]:
        shown = f"a median of {median:.0f} K" if np.isfinite(median) else "most pixels without a temperature"
        raise BadInput(f"{complaint}: {shown}")
