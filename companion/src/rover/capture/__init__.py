"""Where frames come from: one type of frame, several sources behind a registry."""

# Each adds itself to SOURCES.
from rover.capture import camera_socket, cptv, file_frames, folder, mcap_log, v4l2, video  # noqa: F401
from rover.capture.frame import Frame
from rover.capture.source import SOURCES, FrameSource, open_source

__all__ = ["SOURCES", "Frame", "FrameSource", "open_source"]
