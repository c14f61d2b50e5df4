"""Rigs as the companion sees them: what drives a mission, what starts a simulated one, and their names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from rover import plugins
from rover.link.clock import Clock

if TYPE_CHECKING:
    from rover.capture.frame import Frame
    from rover.link.frames import FrameTransport


class RigName(str, Enum):
    """What a mission can be driven on."""

    SITL = "sitl"
    EMULATOR = "emulator"
    DEVICE = "device"


class TransportName(str, Enum):
    """What lies between companion and firmware."""

    SERIAL = "serial"
    CAN = "can"


RigStep = Callable[[int, bytes, bytes, bytes], None]
"""Takes what the rig did in one step that ends at a time in µs: the ticks (request of 40 bytes, reply of 16, for each
millisecond), and the bytes of the wire to and from the firmware."""


class Rig(Clock, Protocol):
    """What a mission needs of a rig besides its time."""

    @property
    def transport(self) -> FrameTransport:
        """The wire to the firmware."""
        ...

    @property
    def frames(self) -> Iterable[Frame]:
        """Pictures that have come; iterating takes them."""
        ...

    def next_cycle(self, period: float) -> float:
        """The time at which the next cycle begins; `advance` leads there."""
        ...

    def finish(
        self, zones: Sequence[dict[str, Any]] = (), detections: Sequence[dict[str, Any]] = ()
    ) -> dict[str, Any] | None:
        """Ends the mission for the rig; returns what its referee saw, None where there is none."""
        ...


class SimulatedRig(Rig, Protocol):
    """A rig in virtual time that a client has connected to."""

    def close(self) -> None:
        """Lets go of it. Without `finish` the rig goes on by itself."""
        ...


class StartedRig(Protocol):
    """A simulated rig's process. `port` and `control` are where a client reaches it, `pid` its process id."""

    @property
    def port(self) -> str: ...

    @property
    def control(self) -> str: ...

    @property
    def pid(self) -> int: ...

    def connect(self, baud: int, pipeline: float = 0.0, on_step: RigStep | None = None) -> SimulatedRig:
        """Its only client. `baud` of a serial wire; `pipeline`: seconds that the world runs ahead of the client;
        `on_step` takes what enters and leaves the firmware. Raises PreflightFailed, LinkLost."""
        ...

    def stop(self) -> None:
        """Ends the process."""
        ...


@dataclass(frozen=True)
class RigOptions:
    """What to start: paths as given by the user, `seed` fixes everything random in the rig.

    `transport`: the wire between companion and firmware, "serial" or "can". `former`: the run whose rover drives on.
    """

    mission: Path
    rig: str = "sitl"
    seed: int = 0
    out: Path | None = None
    data: Path | None = None
    linger: float = 60.0
    transport: str = "serial"
    former: Path | None = None


def start_rig(options: RigOptions, log: Path) -> StartedRig:
    """Starts the simulated rig of that name; what it says goes to `log`.

    Raises BadInput for what the rig refuses, PreflightFailed when it is not installed or does not come up.
    """
    start: Callable[[RigOptions, Path], StartedRig] = plugins.load(plugins.RIGS, options.rig)
    return start(options, log)
