"""Pictures of a camera that another process reads: over a unix socket, one header and the pixels for each.

`RVFR` | u32 number | f64 exposure | f64 kelvin per count | u16 width | u16 height | u32 flags | width × height × u16

Little-endian. Exposure in seconds of the system's monotonic clock; flags: bit 0 the shutter was closed; kelvin per
count is 0 for raw counts. Whoever connects gets every picture from then on.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator

import numpy as np

from rover.capture.frame import Frame
from rover.capture.frozen import FrozenPicture
from rover.capture.location import Location
from rover.capture.source import register
from rover.capture.v4l2 import GIVE_UP_AFTER, CameraLost
from rover.errors import BadInput

HEAD = struct.Struct("<4sIddHHI")
MAGIC = b"RVFR"
CLOSED = 1
MAX_SIDE_PX = 8192
# Seconds between two attempts to connect again.
RETRY = 0.25

READ_TIMEOUT = 1.0


def pack_frame(frame: Frame) -> bytes:
    """One picture as it travels."""
    width, height = frame.size
    head = HEAD.pack(
        MAGIC, frame.sequence & 0xFFFF_FFFF, frame.time, frame.kelvin_per_count or 0.0, width, height,
        CLOSED if frame.ffc else 0,
    )  # fmt: skip
    return head + np.ascontiguousarray(frame.counts, dtype="<u2").tobytes()


@register("socket")
class SocketSource:
    """`socket:PATH`: pictures that a camera's own driver process publishes on that unix socket.

    A publisher that goes away is waited for as an unplugged camera is. Raises BadInput when nobody listens at the
    start or what comes are no such pictures, CameraLost when nobody came back within GIVE_UP_AFTER.
    """

    live = True

    def __init__(self, location: str) -> None:
        self.path = Location.parse(location, ()).place
        if not self.path:
            raise BadInput("socket: the path of the socket is missing, as in socket:/run/camera.sock")

    def __iter__(self) -> Iterator[Frame]:
        connection = self._connect()
        if connection is None:
            raise BadInput(f"{self.path}: nobody publishes pictures there")
        frozen = FrozenPicture()
        size: tuple[int, int] | None = None
        while True:
            with connection:
                for frame in self._pictures(connection):
                    size = size or frame.size
                    if frame.size != size:
                        raise BadInput(f"{self.path}: the size of its pictures has changed from {size} to {frame.size}")
                    repeated = frozen.repeats(frame.counts)
                    yield Frame(frame.counts, frame.time, frame.sequence, frame.ffc or repeated,
                                kelvin_per_count=frame.kelvin_per_count, camera=frame.camera)  # fmt: skip
            connection = self._again()

    def _pictures(self, connection: socket.socket) -> Iterator[Frame]:
        """Until the publisher goes away."""
        while True:
            head = self._exactly(connection, HEAD.size)
            if head is None:
                return
            magic, number, exposure, unit, width, height, flags = HEAD.unpack(head)
            if magic != MAGIC or not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
                raise BadInput(f"{self.path}: what comes there are no pictures of rover.capture.camera_socket")
            pixels = self._exactly(connection, 2 * width * height)
            if pixels is None:
                return
            counts = np.frombuffer(pixels, "<u2").reshape(height, width).astype(np.uint16)
            camera = f"socket {self.path}"
            yield Frame(counts, exposure, number, bool(flags & CLOSED), kelvin_per_count=unit or None, camera=camera)

    def _exactly(self, connection: socket.socket, count: int) -> bytes | None:
        data = bytearray()
        while len(data) < count:
            try:
                part = connection.recv(count - len(data))
            except TimeoutError:
                continue
            except OSError:
                return None
            if not part:
                return None
            data += part
        return bytes(data)

    def _connect(self) -> socket.socket | None:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.connect(self.path)
        except OSError:
            connection.close()
            return None
        connection.settimeout(READ_TIMEOUT)
        return connection

    def _again(self) -> socket.socket:
        deadline = time.monotonic() + GIVE_UP_AFTER
        while time.monotonic() < deadline:
            time.sleep(RETRY)
            connection = self._connect()
            if connection is not None:
                return connection
        raise CameraLost(f"{self.path}: its publisher went away and did not come back within {GIVE_UP_AFTER:.0f} s")
