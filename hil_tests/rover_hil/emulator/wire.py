"""The serial wire between the descriptor that the rig holds and the UART's pins, with the time of each byte.

The host's adapter hands bytes on once a millisecond, as adapters on USB do: what the firmware has put into the UART by
the end of one millisecond, and what has left by the end of the next, is the host's then.
"""

from __future__ import annotations

from collections import deque

from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.descriptor import Descriptor

BITS_PER_BYTE = 10
CYCLES_PER_SECOND = CYCLES_PER_US * 1_000_000


class SerialWire:
    """Bytes of the host arrive one after the other at its baud rate; those of the firmware are counted as they end."""

    def __init__(self, chip: Chip, descriptor: int, baud: int) -> None:
        self._line = Descriptor(descriptor)
        self._uart = chip.uarts[0]
        self._baud = baud
        self._byte_cycles = BITS_PER_BYTE * CYCLES_PER_SECOND / baud
        self._line_free = 0.0
        self._arriving: deque[tuple[float, int]] = deque()
        self._alarm = chip.virtual_clock.create_alarm(self._arrived)
        self._outgoing = bytearray()
        self._leaving = 0
        self._uart.on_sent = self._outgoing.append

    @property
    def sent(self) -> int:
        """Bytes of the firmware so far."""
        return self._line.sent

    def receive(self, due: int, start: int) -> bool:
        """Puts the host's bytes up to a total of `due` on the line from cycle `start` on; see `Descriptor.read`.

        The rig has counted them against the line's rate, so that they fit into this millisecond."""
        data = self._line.read(due)
        for byte in data or b"":
            self._line_free = max(self._line_free, float(start)) + self._byte_cycles
            self._arriving.append((self._line_free, byte))
        if self._arriving and not self._alarm.scheduled:
            self._alarm.schedule_at(round(self._arriving[0][0]))
        return data is not None

    def _arrived(self) -> None:
        _, byte = self._arriving.popleft()
        self._uart.receive(byte, self._baud)
        if self._arriving:
            self._alarm.schedule_at(round(self._arriving[0][0]))

    def transmit(self) -> None:
        """Hands on what was in the UART a millisecond ago and has left it."""
        count = min(self._leaving, len(self._outgoing))
        self._line.write(self._outgoing[:count])
        del self._outgoing[:count]
        self._leaving = len(self._outgoing) + self._uart.unsent
