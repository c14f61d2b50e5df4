"""A picture file's pixels, whatever it is: PNG, TIFF with one page or many, JPEG, PGM, BMP."""

from __future__ import annotations

import io
import struct
import warnings
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rover.bounds import check_pixels
from rover.capture.decoders import decode_quietly
from rover.capture.jpeg_segments import START_OF_IMAGE, check_end
from rover.capture.tiff import decode_page
from rover.capture.tiff_pages import is_tiff, picture_pages
from rover.errors import BadInput

KINDS = "PNG, TIFF, JPEG, PGM or BMP"


@dataclass(frozen=True, eq=False)
class Raster:
    """pixels: (H, W) uint8, uint16, float32 or float64. frames: how many pictures of this size the file holds."""

    pixels: NDArray[Any]
    frames: int


def decode_raster(content: bytes, name: str, frame: int = 1) -> Raster:
    """The picture numbered `frame` from 1; colour is turned into grey.

    Raises BadInput naming `name` for what is no picture, is damaged, or has no such frame.
    """
    frames = 1
    if is_tiff(content):
        pages = picture_pages(content, name)
        frames = len(pages)
        check_frame(frame, frames, name)
        pixels = decode_page(content, pages[frame - 1], name)
    else:
        check_frame(frame, frames, name)
        check_declared_size(content, name)
        if content.startswith(START_OF_IMAGE):
            check_end(content, name)
        decoded = decode_quietly(content)
        if decoded is None:
            raise BadInput(f"{name}: not a readable picture: damaged, cut, or no {KINDS}")
        pixels = decoded
    if pixels.ndim == 3 and pixels.shape[2] == 2:
        pixels = pixels[:, :, 0]  # grey with transparency
    if pixels.ndim == 3 and pixels.shape[2] > 1:
        pixels = np.asarray(cv2.cvtColor(pixels[:, :, :3], cv2.COLOR_BGR2GRAY))
    pixels = pixels.reshape(pixels.shape[:2])
    if pixels.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise BadInput(f"{name}: {pixels.dtype} pixels; 8 or 16 bits, or floating point, expected")
    return Raster(pixels, frames)


def check_declared_size(content: bytes, name: str) -> None:
    """Raises BadInput for a picture that declares more pixels than are taken in; what is no picture passes."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(content)) as picture:
                width, height = picture.size
    except Image.DecompressionBombError as error:
        raise BadInput(f"{name}: more pixels than are taken in") from error
    except (OSError, SyntaxError, ValueError, EOFError, struct.error):
        return
    check_pixels(width, height, name)


def check_frame(frame: int, frames: int, name: str) -> None:
    """Raises BadInput where a file of so many frames has none of that number."""
    if not 1 <= frame <= frames:
        raise BadInput(f"{name}: no frame {frame}: it holds {'one' if frames == 1 else f'1 to {frames}'}")
