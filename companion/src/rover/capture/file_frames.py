"""All pictures of one file: a radiometric sequence (SEQ, FFF), a TIFF of many pages, or a single picture."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rover.capture.frame import Frame
from rover.capture.location import Location
from rover.capture.picture import read_picture_of_many
from rover.capture.source import FRAME_PERIOD, register
from rover.errors import BadInput
from rover.plain_file import plain_file


@register("file")
class FileSource:
    """`file:FILE[?fps=8.7][&unit=centikelvin|raw]`: its pictures in their order; 8 bits are grey levels of no unit.

    Raises BadInput for a file that is missing, damaged or no picture.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("fps", "unit"))
        self.file = Path(parsed.place)
        self.period = 1.0 / parsed.number("fps", 1.0 / FRAME_PERIOD)
        self._unit = parsed.unit("centikelvin")
        if not plain_file(self.file).is_file():
            raise BadInput(f"{self.file}: no such picture")

    def __iter__(self) -> Iterator[Frame]:
        number, frames = 1, 1
        while number <= frames:
            picture, frames = read_picture_of_many(self.file, number)
            unit = None if picture.dtype == "uint8" else self._unit
            yield Frame(picture.astype("uint16"), (number - 1) * self.period, number - 1, kelvin_per_count=unit)
            number += 1
