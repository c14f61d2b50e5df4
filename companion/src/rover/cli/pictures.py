"""Pictures for commands, from any source: plain files and folders, or `kind:location` as in `rover.capture`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rover.cli.output import say
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.capture.frame import Frame

SOURCE = "SOURCE"
SOURCE_HELP = "Picture, folder, or a source: cptv:, mcap:, video:, v4l2:, rtsp: and others; of each ?skip=N&count=N."
DEFAULT_STEPS = "stretch,clahe"
STEPS_HELP = (
    "Steps before features are looked for: fixed-pattern, dead-pixels, gaussian, stretch, equalizeHist, clahe, or none."
)
# Memory for the pictures of one command.
MAX_BYTES = 2**30
PARTS = ("skip", "count")


@dataclass(frozen=True, eq=False)
class Shot:
    """name: the file, or the source with the number of the frame from 1. picture: (H, W) of 8 or 16 bits."""

    name: str
    picture: NDArray[np.uint8] | NDArray[np.uint16]


def read_picture(file: Path | str) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """As `rover.capture.picture.read_picture`; of a source that is no picture file, its first frame."""
    from rover.capture.picture import EXTENSIONS, read_picture_of_many

    if is_source(str(file)) and Path(file).suffix.lower() not in EXTENSIONS:
        return next(shots([str(file)])).picture
    picture, frames = read_picture_of_many(file)
    say_frame(Path(file), frames)
    return picture


def say_frame(file: Path, frames: int) -> None:
    """One line on stderr where the file holds more than the picture that is used."""
    if frames > 1:
        say(f"{file}: frame 1 of {frames} is used")


def expanded(sources: Sequence[str]) -> list[str]:
    """Folders as their files, everything else as it is. Raises BadInput for a folder without pictures."""
    from rover.capture.picture import files_of

    found: list[str] = []
    for source in sources:
        is_folder = not is_source(source) and Path(source).is_dir()
        found += map(str, files_of(source)) if is_folder else [source]
    return found


def all_shots(sources: Sequence[str]) -> list[Shot]:
    """Every picture of the sources, held in memory. Raises BadInput, also where they are more than MAX_BYTES."""
    found: list[Shot] = []
    held = 0
    for shot in shots(sources):
        held += shot.picture.nbytes
        if held > MAX_BYTES:
            raise BadInput(f"{shot.name}: over {MAX_BYTES // 2**20} MB of pictures: take fewer, as by ?skip=N&count=N")
        found.append(shot)
    return found


def shots(sources: Sequence[str]) -> Iterator[Shot]:
    """The pictures of the sources one after the other. Raises BadInput."""
    from rover.capture.picture import EXTENSIONS, read_picture_of_many

    for source in expanded(sources):
        place = Path(source)
        if not is_source(source) or (place.is_file() and place.suffix.lower() in EXTENSIONS):
            picture, frames = read_picture_of_many(source)
            say_frame(place, frames)
            yield Shot(source, picture)
        else:
            yield from _of_source(source)


def frames_of(source: str) -> Iterator[Frame]:
    """The frames of a source, `?skip=N` left out and no more than `?count=N`. Raises BadInput."""
    from itertools import islice

    from rover.capture import open_source

    place, options = _parted(source)
    opened = open_source(place)
    yield from islice(opened, options["skip"], None if options["count"] is None else _end(options))
    if getattr(opened, "cut", False):
        say(f"{place}: damaged or cut; what stands before is used")


def check_end(source: str) -> None:
    """Raises BadInput for a live source without a number of pictures."""
    if is_live(source) and _parted(source)[1]["count"] is None:
        raise BadInput(f"{source}: a camera has no last picture: say how many, as with ?count=20")


def is_live(source: str) -> bool:
    """Whether a source gives pictures as they are taken, without an end."""
    from rover.capture.source import SOURCES, kind_of

    kind = source.partition(":")[0] if ":" in source and not Path(source).exists() else kind_of(source)
    return bool(getattr(SOURCES.get(kind), "live", False))


def _of_source(source: str) -> Iterator[Shot]:
    import numpy as np

    check_end(source)
    place, options = _parted(source)
    number = options["skip"] or 0
    for frame in frames_of(source):
        number += 1
        is_grey = frame.kelvin_per_count is None and int(frame.counts.max(initial=0)) < 256
        yield Shot(f"{place}#{number}", frame.counts.astype(np.uint8) if is_grey else frame.counts)


def is_source(text: str) -> bool:
    """Whether it is more than the plain path of a picture or folder."""
    from rover.capture.source import kind_of

    place = Path(text)
    if place.exists():
        holds_many = place.suffix.lower() in (".seq", ".csq", ".fff")
        return not place.is_dir() and (holds_many or kind_of(text) not in ("folder", "file"))
    return ":" in text or "?" in text or kind_of(text) in ("cptv", "mcap", "video", "v4l2")


def _end(options: dict[str, int | None]) -> int:
    return (options["skip"] or 0) + (options["count"] or 0)


def _parted(source: str) -> tuple[str, dict[str, int | None]]:
    """The source without `skip` and `count`, and these. Raises BadInput."""
    place, _, query = source.partition("?")
    if Path(source).exists():
        place, query = source, ""
    rest: list[str] = []
    options: dict[str, int | None] = dict.fromkeys(PARTS)
    for pair in filter(None, query.split("&")):
        key, _, value = pair.partition("=")
        if key not in PARTS:
            rest.append(pair)
        elif not value.isdigit() or (key == "count" and int(value) == 0):
            raise BadInput(f"{source}: {pair}: a whole number is expected")
        else:
            options[key] = int(value)
    return place + ("?" + "&".join(rest) if rest else ""), options
