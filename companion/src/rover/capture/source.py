"""Sources of frames behind one registry: a source is an iterator of `Frame`, opened by `kind:location`.

    for frame in open_source("folder:recordings/2024-05-01"): ...

A new kind of camera is one class with `@register("name")`; nothing else changes. Other packages add theirs as entry
points, see `rover.plugins`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol

from rover import plugins
from rover.capture.frame import Frame
from rover.errors import BadInput

# Seconds between frames where a source has no times of its own (8.7 Hz cameras, rounded up).
FRAME_PERIOD = 0.12

# The kind that comes with the simulated rigs.
SIMULATOR = "simulator"


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


def open_source(location: str) -> FrameSource:
    """Opens `kind:location`; a plain path is a folder.

    Raises BadInput for an unknown kind or a bad location, PreflightFailed for a kind whose package is not installed.
    """
    kind, separator, rest = location.partition(":")
    if not separator:
        kind, rest = "folder", location
    if kind in SOURCES:
        return SOURCES[kind](rest)
    added = plugins.names(plugins.CAMERAS)
    if kind in added:
        factory: Callable[[str], FrameSource] = plugins.load(plugins.CAMERAS, kind)
        return factory(rest)
    if kind == SIMULATOR:
        raise plugins.missing(f"the frame source '{SIMULATOR}'")
    raise BadInput(f"{location}: no frame source '{kind}'; known: {', '.join(sorted({*SOURCES, *added}))}")
