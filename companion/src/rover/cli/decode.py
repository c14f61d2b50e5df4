"""`rover decode`: a radiometric file to temperatures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text

if TYPE_CHECKING:
    from rover.capture.radiometric import Thermogram

HELP = """Decode a radiometric picture: FLIR and Zenmuse JPEG, FLIR's FFF, 16-bit TIFF or PNG in kelvin × 100.

Emissivity, reflected temperature, air, distance and window are taken from the file.

\b
Examples:
  rover decode IR_0012.jpg
  rover decode IR_0012.jpg --json | jq .max_c
  rover decode IR_0012.jpg --tiff IR_0012.tiff     16 bits, kelvin × 100, as every other command reads it
"""


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The radiometric file.")],
    tiff: Annotated[Path | None, typer.Option("--tiff", metavar="OUT", help="Write kelvin × 100, 16 bits.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.capture.radiometric import read_thermogram, write_counts

    thermogram = read_thermogram(file)
    if tiff is not None:
        write_counts(tiff, thermogram.kelvin)
    found = document(thermogram)
    if as_json:
        write_json(found)
    else:
        write_text(
            f"{found['camera']}, {found['width']}×{found['height']}: {found['min_c']:.2f} to {found['max_c']:.2f} °C, "
            f"mean {found['mean_c']:.2f} °C, centre {found['centre_c']:.2f} °C"
        )
    return 0


def document(thermogram: Thermogram) -> dict[str, Any]:
    """The picture's figures; pixels without a temperature are left out of them."""
    import numpy as np

    from rover.capture.radiometry import ZERO_CELSIUS

    celsius = thermogram.kelvin.astype(np.float64) - ZERO_CELSIUS
    height, width = celsius.shape
    return {
        "camera": thermogram.camera,
        "width": width,
        "height": height,
        "min_c": round(float(np.nanmin(celsius)), 3),
        "max_c": round(float(np.nanmax(celsius)), 3),
        "mean_c": round(float(np.nanmean(celsius)), 3),
        "centre_c": round(float(celsius[height // 2, width // 2]), 3),
    }
