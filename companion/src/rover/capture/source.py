"""Sources of frames behind one registry: a source is an iterator of `Frame`, opened by `kind:location`.

    for frame in open_source("folder:recordings/2024-05-01"): ...

A new kind of camera is one class with `@register("name")`; nothing else changes. Other packages add theirs as entry
points, see `rover.plugins`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

from rover import plugins
from rover.capture.frame import Frame
from rover.errors import BadInput

# Seconds between frames where a source has no times of its own (8.7 Hz cameras, rounded up).
FRAME_PERIOD = 0.12

# The kind that comes with the simulated rigs.
SIMULATOR = "simulator"


# What a plain file is taken for.
ENDINGS = {
    "cptv": (".cptv",),
    "mcap": (".mcap",),
    "video": (".avi", ".mkv", ".mov", ".mp4", ".m4v", ".mpg", ".webm"),
    "file": (".seq", ".csq", ".fff", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".pgm", ".bmp"),
}


class FrameSource(Protocol):
    """Anything that yields frames in the order of their exposure."""

    def __iter__(self) -> Iterator[Frame]: ...


SOURCES: dict[str, Callable[[str], FrameSource]] = {}


def register(kind: str) -> Callable[[Callable[[str], FrameSource]], Callable[[str], FrameSource]]:
    """Class decorator: makes a source available to `open_source` under `kind`."""

    def add(factory: Callable[[str], FrameSource]) -> Callable[[str], FrameSource]:
        SOURCES[kind] = factory
        return factory

    return add


def open_camera(location: str) -> FrameSource:
    """As `open_source`, but only a source that gives pictures as they are taken, by the system's monotonic clock."""
    source = open_source(location)
    if not getattr(source, "live", False):
        live = ", ".join(kind for kind, factory in sorted(SOURCES.items()) if getattr(factory, "live", False))
        raise BadInput(f"{location}: holds pictures of another time; a mission on a real rover sees by one of: {live}")
    return source


def kind_of(location: str) -> str:
    """The kind of source for a plain path: by its ending, a device by where it lies; anything else is a folder."""
    place = Path(location.partition("?")[0])
    if place.is_dir():
        return "folder"
    if str(place).startswith("/dev/video"):
        return "v4l2"
    return next((kind for kind, endings in ENDINGS.items() if place.suffix.lower() in endings), "folder")


def open_source(location: str) -> FrameSource:
    """Opens `kind:location`; of a plain path the kind follows from what is there, see `kind_of`.

    Raises BadInput for an unknown kind or a bad location, PreflightFailed for a kind whose package is not installed.
    """
    kind, separator, rest = location.partition(":")
    if not separator or (kind not in SOURCES and Path(location.partition("?")[0]).exists()):
        kind, rest = kind_of(location), location
    if kind in SOURCES:
        return SOURCES[kind](rest)
    added = plugins.names(plugins.CAMERAS)
    if kind in added:
        factory: Callable[[str], FrameSource] = plugins.load(plugins.CAMERAS, kind)
        return factory(rest)
    if kind == SIMULATOR:
        raise plugins.missing(f"the frame source '{SIMULATOR}'")
    raise BadInput(f"{location}: no frame source '{kind}'; known: {', '.join(sorted({*SOURCES, *added}))}")
