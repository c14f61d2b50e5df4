"""Names of ports: a serial device, or a CAN bus as `can:INTERFACE:CHANNEL` in python-can's words."""

from __future__ import annotations

from dataclasses import dataclass

from rover.errors import BadInput

CAN_BITRATE = 500_000

# Bits of a classic frame with an 11-bit identifier around its payload, with the gap to the next (ISO 11898-1).
CAN_FRAME_BITS = 47

# Bits per second of a line that carries CAN frames as text: a frame takes on it what it takes on the bus. Eight bytes
# of payload are 22 characters, 220 µs at this rate, and about 111 bits, 222 µs, at CAN_BITRATE.
SLCAN_BAUD = 1_000_000


@dataclass(frozen=True)
class CanPort:
    """A bus: python-can's name of the interface, and the channel that it opens."""

    interface: str
    channel: str

    @property
    def name(self) -> str:
        """As the user writes it."""
        return f"can:{self.interface}:{self.channel}"


def parse_port(port: str) -> CanPort | str:
    """A CanPort for `can:…`, otherwise the name of a serial device as it is. Raises BadInput."""
    if not port.startswith("can:"):
        return port
    _, interface, channel = [*port.split(":", 2), "", ""][:3]
    if not interface or not channel:
        raise BadInput(f"--port {port}: a CAN port is written can:INTERFACE:CHANNEL, as in can:socketcan:can0")
    return CanPort(interface, channel)
