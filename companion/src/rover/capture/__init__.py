"""Where frames come from: one type of frame, several sources behind a registry."""

from rover.capture.frame import Frame
from rover.capture.source import SOURCES, FrameSource, open_source

__all__ = ["SOURCES", "Frame", "FrameSource", "open_source"]
