"""How much is left in the battery, by its voltage, and what the way back takes of it.

A voltage says how full a pack is only after what its inner resistance costs at the present load is added. All of it is
an estimate: the reserve keeps half of the way back in hand, and the firmware's own limit stands below.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from statistics import median

from rover.link.telemetry import Battery
from rover.vehicle import Pack

# Open-circuit voltage of a lithium-ion cell by its charge, 0 to 1: typical of NMC cells at 25 °C.
OPEN_CIRCUIT = ((0.0, 3.0), (0.05, 3.3), (0.1, 3.45), (0.25, 3.6), (0.5, 3.72), (0.75, 3.92), (1.0, 4.2))
# Seconds whose median counts: motors that start pull the voltage down for a moment.
WINDOW_S = 5.0
# The way back is reckoned to cost this much more than it should, and this many seconds of stops and turns.
MARGIN = 1.5
STOPS_S = 20.0


def charge_of(volts: float) -> float:
    """Charge of a cell, 0 to 1, of which that is the open-circuit voltage."""
    if volts <= OPEN_CIRCUIT[0][1]:
        return 0.0
    above = bisect_right([voltage for _, voltage in OPEN_CIRCUIT], volts)
    if above == len(OPEN_CIRCUIT):
        return 1.0
    (low, start), (high, end) = OPEN_CIRCUIT[above - 1], OPEN_CIRCUIT[above]
    return low + (high - low) * (volts - start) / (end - start)


class Gauge:
    """Of one pack. Times are seconds of the companion's clock."""

    def __init__(self, pack: Pack) -> None:
        self._pack = pack
        self._lately: deque[tuple[float, float]] = deque()

    def take(self, battery: Battery) -> None:
        """A measurement."""
        self._lately.append((battery.time, battery.voltage))
        while battery.time - self._lately[0][0] > WINDOW_S:
            self._lately.popleft()

    @property
    def left_wh(self) -> float | None:
        """Watt hours until the firmware's limit; None until the voltage has been watched for long enough."""
        if not self._lately or self._lately[-1][0] - self._lately[0][0] < 0.6 * WINDOW_S:
            return None
        pack, volts = self._pack, median(voltage for _, voltage in self._lately)
        lost = pack.power_w / max(volts, 1.0) * pack.resistance_ohm
        full, empty = (charge_of((level + lost) / pack.cells) for level in (volts, pack.low_v))
        return pack.capacity_wh * max(full - empty, 0.0)

    @property
    def left_s(self) -> float | None:
        """Seconds of driving until the firmware's limit."""
        left = self.left_wh
        return None if left is None else left / self._pack.power_w * 3600.0

    def spent(self, way_back: float) -> bool:
        """True when what is left is needed for a way back of so many seconds."""
        left = self.left_s
        return left is not None and left < way_back * MARGIN


def way_back_s(way_m: float, speed: float) -> float:
    """Seconds that a way takes, with stops and turns on it."""
    return way_m / speed + STOPS_S
