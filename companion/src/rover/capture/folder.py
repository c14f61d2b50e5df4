"""Frames from a folder of pictures: 16-bit PNG and TIFF, or radiometric JPEGs of FLIR and Zenmuse cameras."""

from __future__ import annotations

from collections.abc import Iterator

from rover.capture.frame import Frame
from rover.capture.location import Location
from rover.capture.picture import files_of, read_counts
from rover.capture.radiometric import read_thermogram
from rover.capture.source import FRAME_PERIOD, register
from rover.capture.temperatures import as_centikelvin
from rover.errors import BadInput


@register("folder")
class FolderSource:
    """`folder:DIR[?fps=8.7][&unit=centikelvin|raw]`: 16-bit PNG or TIFF files in the order of their names.

    Every picture must have the size of the first. Raises BadInput naming the file that does not fit.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("fps", "unit"))
        self.files = files_of(parsed.place, (".png", ".tif", ".tiff"), "PNG or TIFF")
        self.period = 1.0 / parsed.number("fps", 1.0 / FRAME_PERIOD)
        self._unit = parsed.unit("centikelvin")

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[Frame]:
        size: tuple[int, int] | None = None
        for sequence, file in enumerate(self.files):
            frame = Frame(read_counts(file), sequence * self.period, sequence, kelvin_per_count=self._unit)
            size = same_size(frame, size, file)
            yield frame


@register("radiometric")
class RadiometricSource:
    """`radiometric:DIR[?fps=1]`: radiometric JPEG or FFF files by name, decoded to kelvin × 100 (0: no temperature)."""

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("fps",))
        self.files = files_of(parsed.place, (".jpg", ".jpeg", ".fff"), "radiometric JPEG or FFF")
        self.period = 1.0 / parsed.number("fps", 1.0)

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[Frame]:
        size: tuple[int, int] | None = None
        for sequence, file in enumerate(self.files):
            decoded = read_thermogram(file)
            counts = as_centikelvin(decoded.kelvin)
            frame = Frame(counts, sequence * self.period, sequence, camera=decoded.camera)
            size = same_size(frame, size, file)
            yield frame


def same_size(frame: Frame, size: tuple[int, int] | None, name: object) -> tuple[int, int]:
    """The size of every frame so far; None: this is the first. Raises BadInput for another one."""
    if size is not None and frame.size != size:
        raise BadInput(f"{name}: {frame.size[0]}×{frame.size[1]}, the first frame is {size[0]}×{size[1]}")
    return frame.size
