"""What every rig offers: virtual time that moves when asked, frames, and the totals of the serial wire.

`sitl` runs the firmware's core as a desktop process; further rigs fill the same interface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from rover.errors import RoverError

Mark = tuple[int, int]
"""Time in µs, and the total of bytes that the firmware had sent by then."""


class RigFailed(RoverError):
    """The rig cannot go on: the firmware's process has ended, or the wire is gone."""


@dataclass(frozen=True)
class RigFrame:
    """A delivered picture; `counts` are uint16 little-endian kelvin × 100, row-major."""

    sequence: int
    exposure_us: int
    delivered_us: int
    ffc: bool
    counts: bytes


@dataclass(frozen=True)
class Advance:
    """What happened in (previous time, now_us]."""

    now_us: int
    marks: tuple[Mark, ...]
    frames: tuple[RigFrame, ...]
    ticks: bytes = b""
    """Requests and replies of the firmware's ticks, 40 and 16 bytes each; empty unless they are recorded."""
    to_firmware: bytes = b""
    from_firmware: bytes = b""
    """Bytes of the wire: handed to the firmware at the step's beginning, and sent by it in the step; as above."""


class SteppedRig(Protocol):
    """What a companion's session asks of a rig."""

    @property
    def name(self) -> str:
        """As in --rig."""
        ...

    @property
    def now_us(self) -> int:
        """Virtual time, µs."""
        ...

    @property
    def camera(self) -> dict[str, Any]:
        """What the companion may know of the camera: name, width, height, period_us, latency_us."""
        ...

    def begin_session(self) -> None:
        """A companion has come: it counts its bytes from here on."""
        ...

    def record(self) -> None:
        """From here on `Advance` holds ticks and bytes of the wire."""
        ...

    def advance(self, to_us: int, host_bytes: int) -> Advance:
        """Runs until `to_us`; `host_bytes` is the companion's total up to the present. Raises RigFailed."""
        ...

    def set_emergency_stop(self, active: bool) -> None:
        """Presses or releases the emergency-stop input."""
        ...


class Rig(SteppedRig, Protocol):
    """One rig with one firmware and one serial port."""

    @property
    def port(self) -> str:
        """Name of the serial port."""
        ...

    def advance_free(self, to_us: int) -> tuple[RigFrame, ...]:
        """Runs until `to_us` with whatever comes over the port; returns the pictures of that time. Raises RigFailed."""
        ...

    def truth(self) -> NDArray[np.float64]:
        """True trajectory (n, 4): time s, x, y, heading."""
        ...

    def seen(self) -> NDArray[np.bool_]:
        """Ground that the camera has shown, (rows, columns) of 1 cm."""
        ...

    def verdict(self) -> dict[str, Any]:
        """The referee's counts so far."""
        ...

    def close(self) -> None:
        """Ends firmware and port; may be called twice."""
        ...
