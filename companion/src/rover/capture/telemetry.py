"""The telemetry that a Lepton sends in rows of its picture: whether the shutter is closed, and which frame it is.

Lepton Engineering Datasheet (500-0659-00-09 rev 203), section 3.4: rows A, B, C (and D, reserved, on Lepton 3) of 80
words of 16 bits; values of 32 bits come low word first. Above or below the picture, as the camera was told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROW_WORDS = 80
# Telemetry packets of a frame by the picture's width: Lepton 3 (two rows of 160 words), Lepton 2 (three of 80).
PACKETS = {160: 4, 80: 3}

# Where a working sensor's own temperature lies; ordinary pixels rarely pass for telemetry with this and the rest.
SENSOR_KELVIN = (200.0, 400.0)

# AGC State in the status bits.
AGC_BIT = 12
# The camera counts its uptime in 32 bits of milliseconds.
UPTIME_WRAP_S = 2**32 * 1e-3
# Nobody leaves a camera longer than a day without a correction across that wrap.
MAX_SINCE_FFC_MS = 86_400_000
FFC_STATES = ("never", "imminent", "running", "complete")
# Words of row A that are sent as zero.
RESERVED = (17, 18, 19, 27, 28)


@dataclass(frozen=True)
class Telemetry:
    """Row A, and TLinear from row C.

    uptime, uptime_at_ffc: seconds since the camera started. ffc_state: one of FFC_STATES.
    sensor_kelvin: temperature of the focal plane. kelvin_per_count: from TLinear; None for raw counts. agc: gain
    control is on, and the picture holds grey levels.
    """

    frame_counter: int
    uptime: float
    uptime_at_ffc: float
    ffc_state: str
    sensor_kelvin: float
    kelvin_per_count: float | None
    agc: bool

    @property
    def since_ffc(self) -> float:
        """Seconds since the last flat-field correction."""
        return (self.uptime - self.uptime_at_ffc) % UPTIME_WRAP_S


def parse_words(words: NDArray[np.uint16]) -> Telemetry | None:
    """Telemetry from its words, 240 or 320 of them; None when they cannot be telemetry."""
    if words.size < 3 * ROW_WORDS or words[0] == 0 or np.any(words[list(RESERVED)]):
        return None

    def double(at: int) -> int:
        return int(words[at]) | int(words[at + 1]) << 16

    sensor_kelvin = float(words[24]) / 100.0
    uptime_ms, at_ffc_ms = double(1), double(30)
    # Behind 49.7 days the uptime begins anew, and the last correction lies in the time before.
    is_later = at_ffc_ms > uptime_ms and (uptime_ms - at_ffc_ms) % 2**32 > MAX_SINCE_FFC_MS
    if not SENSOR_KELVIN[0] < sensor_kelvin < SENSOR_KELVIN[1] or is_later:
        return None
    status = double(3)
    linear, resolution = int(words[2 * ROW_WORDS + 48]), int(words[2 * ROW_WORDS + 49])
    return Telemetry(
        frame_counter=double(20),
        uptime=uptime_ms * 1e-3,
        uptime_at_ffc=at_ffc_ms * 1e-3,
        ffc_state=FFC_STATES[status >> 4 & 3],
        sensor_kelvin=sensor_kelvin,
        kelvin_per_count=(0.01 if resolution else 0.1) if linear else None,
        agc=bool(status >> AGC_BIT & 1),
    )


def split_telemetry(delivered: NDArray[np.uint16]) -> tuple[NDArray[np.uint16], Telemetry | None]:
    """A delivered picture (H, W) as the picture alone and its telemetry; None and the whole picture without one."""
    packets = PACKETS.get(delivered.shape[1])
    if packets is None:
        return delivered, None
    rows = packets * ROW_WORDS // delivered.shape[1]
    for telemetry_rows, picture in (
        (delivered[-rows:], delivered[:-rows]),  # footer: the default of the camera
        (delivered[:rows], delivered[rows:]),
    ):
        found = parse_words(telemetry_rows.reshape(-1))
        if found is not None:
            return picture, found
    return delivered, None
