"""A real rover for a mission: its port and its camera opened, looked at, and driven in real time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rover.capture import open_source  # noqa: F401  fills the registry
from rover.capture.latest import LatestFrames
from rover.capture.source import open_camera
from rover.errors import BadInput
from rover.link.clock import WallClock
from rover.link.frames import FrameTransport, SerialFrames
from rover.link.opening import open_frames
from rover.link.self_test import Finding
from rover.mission.config import Mission
from rover.mission.preflight import preflight
from rover.vision.camera.model import CameraModel

# Pictures kept while a cycle takes longer than they come: planning takes a tenth of a second now and then.
DEPTH = 4


@dataclass(frozen=True)
class Device:
    """What is open, and the clock that all of it goes by."""

    clock: WallClock
    wire: FrameTransport
    camera: LatestFrames

    @property
    def byte_time(self) -> float:
        """Seconds that a byte takes on a serial line; 0 on USB and on a bus."""
        return self.wire.bytes.byte_time if isinstance(self.wire, SerialFrames) else 0.0


@contextmanager
def opened(mission: Mission, port: str | None, camera_source: str | None) -> Iterator[Device]:
    """Port and camera while the block runs. Raises BadInput, PreflightFailed."""
    if port is None:
        raise BadInput("--rig device: which board? name its port with --port, as /dev/ttyACM0 or can:socketcan:can0")
    source = camera_source or mission.rover.camera_source
    if not source:
        raise BadInput(
            "--rig device: which camera? name it with --camera-source, or camera_source in the mission's [rover], "
            "as v4l2:/dev/video0"
        )
    pictures = open_camera(source)
    clock = WallClock()
    wire = open_frames(port, mission.rover.baud, clock)
    try:
        with LatestFrames(pictures, DEPTH) as camera:
            yield Device(clock, wire, camera)
    finally:
        wire.close()


def check(
    device: Device, mission: Mission, camera: CameraModel, out: Path, seed: int, on_finding: Callable[[Finding], None]
) -> None:
    """The pre-flight check. Raises PreflightFailed when the rover may not set off."""
    preflight(device, mission, camera, out, seed & 0xFFFF, on_finding).require()
