"""`rover decode`: a radiometric file to temperatures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.cli.pictures import SOURCE
from rover.errors import BadInput

if TYPE_CHECKING:
    from rover.capture.radiometric import Thermogram
    from rover.capture.radiometry import Surroundings

HELP = """Decode radiometric pictures: FLIR and Zenmuse XT JPEG, FLIR's FFF and SEQ, TIFF, PNG, or any source.

16 bits are kelvin × 100, floating point is kelvin or °C. Emissivity, reflected temperature, humidity, air, distance and
window are taken from the file; the first three and the distance can be given instead, for files of FLIR's kind. Of a
file, folder, clip or log with many frames each is named, or the one of --frame; of a camera one picture is taken, or
?count=N.

\b
Examples:
  rover decode IR_0012.jpg
  rover decode IR_0012.jpg --json | jq .max_c
  rover decode drive.seq --frame 3
  rover decode flight/                                         every file of a folder
  rover decode clip.cptv?unit=centikelvin --frame 20 --tiff OUT.tiff
  rover decode v4l2:0 --json                                   what the camera sees now
  rover decode IR_0012.jpg --emissivity 0.92 --reflected-c -20 --distance-m 3
  rover decode IR_0012.jpg --tiff IR_0012.tiff     16 bits, kelvin × 100, as every other command reads it
"""
RADIOMETRIC = (".jpg", ".jpeg", ".fff", ".seq", ".png", ".tif", ".tiff")


def command(
    source: Annotated[str, typer.Argument(metavar=SOURCE, help="Radiometric file, folder or other source.")],
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
    from rover.capture.radiometry import ZERO_CELSIUS, Surroundings
    from rover.capture.temperatures import as_centikelvin
    from rover.cli.out_file import spare_inputs

    told = Surroundings(emissivity, None if reflected_c is None else reflected_c + ZERO_CELSIUS, distance_m, humidity)
    chosen: Thermogram | None = None
    found: list[tuple[str, dict[str, Any]]] = []
    for name, thermogram in thermograms(source, frame, told):
        is_chosen = thermogram.frame == (frame or 1)
        chosen = thermogram if is_chosen else chosen
        if is_chosen or frame is None:
            found.append((name, document(thermogram)))
        frames = thermogram.frames
    if chosen is None:
        raise BadInput(f"{source}: no frame {frame}: it holds {'one' if frames == 1 else f'1 to {frames}'}")
    if tiff is not None:
        spare_inputs(tiff, [Path(source.partition("?")[0].rpartition(":")[2]), Path(found[0][0])], "--tiff")
        write_picture(tiff, as_centikelvin(chosen.kelvin))
    if as_json:
        write_json(found[0][1] | {"frames": frames})
        return 0
    is_folder = len({name for name, _ in found}) > 1
    for name, one in found:
        write_text((f"{Path(name).name}: " if is_folder else "") + line(one | {"frames": frames}))
    return 0


def thermograms(source: str, frame: int | None, told: Surroundings) -> Iterator[tuple[str, Thermogram]]:
    """Every frame of a source with the name of its file or source; of one file with `frame` that one alone.

    `frames` of the last one is how many there are. Raises BadInput, also where a source holds no frame.
    """
    from rover.capture.picture import files_of
    from rover.capture.radiometric import read_thermogram, thermogram_of
    from rover.capture.source import kind_of
    from rover.cli.pictures import check_end, frames_of, is_live, is_source

    place = Path(source)
    if place.is_dir():
        number = 0
        for file in files_of(place, RADIOMETRIC, "radiometric"):
            chosen = read_thermogram(file, 1, told)
            for page in range(1, chosen.frames + 1):
                number += 1
                shown = chosen if page == 1 else read_thermogram(file, page, told)
                yield str(file), replace(shown, frame=number, frames=number)
        return
    if not is_source(source) or (place.is_file() and kind_of(source) in ("file", "folder")):
        chosen = read_thermogram(source, frame or 1, told)
        yield source, chosen
        for number in range(2, chosen.frames + 1) if frame is None else ():
            yield source, read_thermogram(source, number, told)
        return
    if told.given():
        raise BadInput(f"{source}: its pixels are temperatures already: emissivity and the like cannot be changed")
    if is_live(source) and "count=" not in source:
        source += f"{'&' if '?' in source else '?'}count={frame or 1}"
    check_end(source)
    number = 0
    for number, taken in enumerate(frames_of(source), 1):
        yield source, thermogram_of(taken, number, source)
    if number == 0:
        raise BadInput(f"{source}: it holds no frame")


def line(found: dict[str, Any]) -> str:
    """One frame's figures, as of `document`, for a person."""
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
