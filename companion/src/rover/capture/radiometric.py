"""Radiometric files to temperatures: FLIR and Zenmuse JPEG, FLIR's own FFF and SEQ, and pictures in kelvin or °C."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rover.bounds import read_bounded
from rover.capture import exif, flir_file, jpeg_segments
from rover.capture.frame import Frame
from rover.capture.radiometry import Surroundings
from rover.capture.raster import check_frame, decode_raster
from rover.capture.temperatures import (
    OUTDOORS_KELVIN,
    PLAUSIBLE_KELVIN,
    check_median,
    kelvin_of_counts,
    kelvin_of_floats,
)
from rover.errors import BadInput
from rover.plain_file import plain_file

# How far a single pixel must lie beyond its neighbours, and how many times their own range, to be damage: in pictures
# of four cameras none lies beyond by more than 6 K or by more than its neighbours' range.
SPIKE_KELVIN, SPIKE_RATIO = 30.0, 5.0
AS_IN_THE_FILE = Surroundings()
# Segments of a JPEG in which DJI's own cameras keep their thermal record.
DJI_SEGMENTS = frozenset((0xE3, 0xE4, 0xE5))


@dataclass(frozen=True, eq=False)
class Thermogram:
    """camera: as the file names it. kelvin: (H, W) float32, NaN where the sensor's count means no temperature.

    frame: which of the file's `frames` this is, from 1.
    """

    camera: str
    kelvin: NDArray[np.float32]
    frame: int = 1
    frames: int = 1


def has_thermal_record(data: bytes) -> bool:
    """Whether it is a file of FLIR's, or a JPEG with FLIR's record in it, damaged or not."""
    return data.startswith(flir_file.FILE_SIGNATURE) or (
        data.startswith(jpeg_segments.START_OF_IMAGE) and flir_file.SEGMENT_SIGNATURE in data[:0x20000]
    )


def read_thermogram(path: Path | str, frame: int = 1, told: Surroundings = AS_IN_THE_FILE) -> Thermogram:
    """Decodes a radiometric file, of many frames the one numbered `frame` from 1; told: instead of what the file says.

    Raises BadInput, one line, for a file that is missing, damaged, not radiometric, or has no such frame.
    """
    file = Path(path)
    name = str(file)
    if file.is_dir():
        raise BadInput(f"{name}: a folder, where a radiometric file is expected")
    if not plain_file(file).is_file():
        raise BadInput(f"{name}: no such file")
    data = read_bounded(file)
    if not data:
        raise BadInput(f"{name}: the file is empty")
    if data.startswith(flir_file.FILE_SIGNATURE):
        parts = flir_file.split_frames(data)
        check_frame(frame, len(parts), name)
        return _of_flir(flir_file.parse(parts[frame - 1], name), "", name, told, frame, len(parts))
    if data.startswith(jpeg_segments.START_OF_IMAGE):
        check_frame(frame, 1, name)
        return _of_jpeg(data, name, told)
    if told.given():
        raise BadInput(f"{name}: its pixels are temperatures already: emissivity and the like cannot be changed")
    raster = decode_raster(data, name, frame)
    if raster.pixels.dtype == np.uint8:
        raise BadInput(f"{name}: an 8-bit picture: not a radiometric file")
    is_counts = raster.pixels.dtype == np.uint16
    kelvin = kelvin_of_counts(raster.pixels, name) if is_counts else kelvin_of_floats(raster.pixels, name)
    return Thermogram("unknown", kelvin, frame, raster.frames)


def thermogram_of(frame: Frame, number: int, name: str) -> Thermogram:
    """A source's frame as temperatures; `number` from 1, `frames` as many as have been seen.

    Raises BadInput where its counts are none: grey levels, or a sensor's own counts.
    """
    if frame.kelvin_per_count is None:
        if int(frame.counts.max(initial=0)) < 256:
            raise BadInput(f"{name}: grey levels of 8 bits: no temperatures")
        raise BadInput(
            f"{name}: raw counts{f' of {frame.camera}' if frame.camera else ''} are no temperatures; "
            "if they are kelvin × 100 say so: ?unit=centikelvin"
        )
    if frame.doubt is not None:
        raise BadInput(f"{name}: {frame.doubt}")
    known = np.where(frame.counts > 0, frame.kelvin(), np.nan).astype(np.float32)
    check_median(known, OUTDOORS_KELVIN, f"{name}: frame {number}: counts that are not temperatures")
    return Thermogram(frame.camera or "unknown", known, number, number)


def _of_jpeg(data: bytes, name: str, told: Surroundings) -> Thermogram:
    segments = list(jpeg_segments.segments(data, name))
    camera = exif.camera_name(segments)
    record = flir_file.join_segments(segments, name)
    if record is None:
        if camera.upper().startswith("DJI") and DJI_SEGMENTS & {marker for marker, _ in segments}:
            raise BadInput(
                f"{name}: {camera}: its thermal record is DJI's own, which only DJI's closed SDK decodes; "
                "export temperatures as TIFF with DJI's tools, which this command reads"
            )
        whose = f" of {camera}" if camera else ""
        raise BadInput(f"{name}: a JPEG{whose} without FLIR's thermal record: not a radiometric file")
    jpeg_segments.check_end(data, name)
    return _of_flir(flir_file.parse(record, name), camera, name, told)


def _of_flir(
    content: flir_file.FlirFile, camera: str, name: str, told: Surroundings, frame: int = 1, frames: int = 1
) -> Thermogram:
    kelvin = told.applied(content.radiometry).kelvin(content.raw)
    check_median(kelvin, PLAUSIBLE_KELVIN, f"{name}: damaged thermal record")
    alone = spikes(kelvin)
    if alone:
        raise BadInput(f"{name}: damaged thermal record: {alone} pixels far off all their neighbours")
    return Thermogram(content.model or camera or "unknown", kelvin, frame, frames)


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
