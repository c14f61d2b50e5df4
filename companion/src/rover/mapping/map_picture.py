"""The picture of a map: shades, and where there are none."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile, UnidentifiedImageError

from rover.bounds import check_pixels
from rover.errors import BadInput
from rover.plain_file import plain_file

# What Pillow says of a file that ends early, by the format and the place; the last is a JPEG without its scan.
CUT = ("truncated", "not enough", "reached eof", "cannot load this image")

PNG_END = b"IEND\xaeB`\x82"


@dataclass(frozen=True, eq=False)
class Shades:
    """Rasters (rows, columns), row 0 at the top: shade from 0 (black) to 1 (white); opaque where there is one."""

    shade: NDArray[np.float32]
    opaque: NDArray[np.bool_]


def read_shades(path: Path) -> Shades:
    """Reads PGM, PNG, JPEG, BMP and what else Pillow knows; the shade of a colour is the mean of its channels.

    Raises BadInput for a file that is no picture, is cut, or holds values above its own maximum.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # check_pixels bounds the size; what is damaged gets one line
            picture = Image.open(plain_file(path))
            check_pixels(picture.width, picture.height, str(path))
            _check_maximum(picture, path)
            shades = _shades(picture)
        _check_end(picture, path)
        return shades
    except BadInput:  # is a ValueError, too
        raise
    except UnidentifiedImageError as error:
        raise BadInput(f"{path}: not a readable picture") from error
    except Image.DecompressionBombError as error:
        raise BadInput(f"{path}: too many cells for a map") from error
    except (OSError, SyntaxError, ValueError, EOFError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise BadInput(f"{path}: {error.strerror}") from error
        cut = isinstance(error, EOFError) or any(words in str(error).lower() for words in CUT)
        raise BadInput(f"{path}: the picture is cut" if cut else f"{path}: not a readable picture: {error}") from error


def _shades(picture: Image.Image) -> Shades:
    if picture.mode.startswith("I"):  # 16 bits, or what Pillow has spread over 16 bits
        shade = np.asarray(picture).astype(np.float32) / 65535.0
        return Shades(shade, np.ones(shade.shape, bool))
    if picture.mode == "F":
        raise ValueError("it holds fractions, not shades")
    channels = np.asarray(picture.convert("RGBA" if picture.has_transparency_data else "RGB"))
    shade = channels[:, :, :3].mean(axis=2, dtype=np.float32) / np.float32(255.0)
    opaque = channels[:, :, 3] == 255 if channels.shape[2] == 4 else np.ones(shade.shape, bool)
    return Shades(shade, opaque)


def _check_maximum(picture: ImageFile.ImageFile, path: Path) -> None:
    """Pillow takes what lies above a PGM's maximum for white: a wrong maximum would make free ground of walls."""
    if picture.format != "PPM" or not picture.tile or picture.tile[0].codec_name != "ppm":
        return
    tile = picture.tile[0]
    maximum = int(tile.args[-1]) if isinstance(tile.args, tuple) else int(tile.args or 255)
    values = np.fromfile(path, ">u2" if maximum > 255 else "u1", offset=tile.offset)
    if values.size and values.max() > maximum:
        raise BadInput(f"{path}: holds {values.max()}, above the maximum {maximum} that it states")


def _check_end(picture: ImageFile.ImageFile, path: Path) -> None:
    """Pillow is content with a PNG whose last rows are there without their checksum: nobody knows them to be right."""
    if picture.format == "PNG" and PNG_END not in path.read_bytes():
        raise BadInput(f"{path}: the picture is cut")
