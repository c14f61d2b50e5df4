"""`rover decode`: a radiometric file to temperatures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text

if TYPE_CHECKING:
    from rover.capture.radiometric import Thermogram

HELP = """Decode a radiometric picture: FLIR and Zenmuse XT JPEG, FLIR's FFF and SEQ, TIFF or PNG.

16 bits are kelvin × 100, floating point is kelvin or °C. Emissivity, reflected temperature, humidity, air, distance and
window are taken from the file; the first three and the distance can be given instead, for files of FLIR's kind. Of a
file with many frames each is named, or the one of --frame.

\b
Examples:
  rover decode IR_0012.jpg
  rover decode IR_0012.jpg --json | jq .max_c
  rover decode drive.seq --frame 3
  rover decode IR_0012.jpg --emissivity 0.92 --reflected-c -20 --distance-m 3
  rover decode IR_0012.jpg --tiff IR_0012.tiff     16 bits, kelvin × 100, as every other command reads it
"""


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The radiometric file.")],
    tiff: Annotated[Path | None, typer.Option("--tiff", metavar="OUT", help="Write kelvin × 100, 16 bits.")] = None,
    frame: Annotated[int | None, typer.Option(min=1, metavar="N", help="Of many frames this one, from 1.")] = None,
    emissivity: Annotated[float | None, typer.Option(metavar="E", help="Of the object, 0.01 to 1.")] = None,
    reflected_c: Annotated[float | None, typer.Option(metavar="C", help="What the object reflects, °C.")] = None,
    distance_m: Annotated[float | None, typer.Option(metavar="M", help="To the object, m.")] = None,
    humidity: Annotated[float | None, typer.Option(metavar="RH", help="Of the air, 0 to 1.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.capture.picture import write_picture
    from rover.capture.radiometric import read_thermogram
    from rover.capture.radiometry import ZERO_CELSIUS, Surroundings
    from rover.capture.temperatures import as_centikelvin

    told = Surroundings(
        emissivity, None if reflected_c is None else reflected_c + ZERO_CELSIUS, distance_m, humidity
    )
    chosen = read_thermogram(file, frame or 1, told)
    if tiff is not None:
        write_picture(tiff, as_centikelvin(chosen.kelvin))
    if as_json:
        write_json(document(chosen))
        return 0
    write_text(line(chosen))
    if frame is None:
        for number in range(2, chosen.frames + 1):
            write_text(line(read_thermogram(file, number, told)))
    return 0


def line(thermogram: Thermogram) -> str:
    """One frame's figures for a person."""
    found = document(thermogram)
    which = f", frame {found['frame']} of {found['frames']}" if found["frames"] > 1 else ""
    return (
        f"{found['camera']}, {found['width']}×{found['height']}{which}: "
        f"{found['min_c']:.2f} to {found['max_c']:.2f} °C, "
        f"mean {found['mean_c']:.2f} °C, centre {found['centre_c']:.2f} °C"
    )


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
        "frame": thermogram.frame,
        "frames": thermogram.frames,
    }
