"""When a mission's clock began: its times are seconds, a record needs a date.

On a real rover that is the system's clock, and how good that is; on a simulated rig the date of the mission file and
the hour that the sun stands at, so that a seed gives the same bytes on any day.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date, datetime, timedelta, timezone

# The simulator's summer day, in a year in which nobody drove: where the mission file gives no date.
SIMULATED_DATE = date(2000, 6, 21)

# Seconds that the sun takes over one degree of longitude.
SOLAR_SECONDS_PER_DEGREE = 240.0

# adjtimex(2): the clock has no source that sets it.
TIME_ERROR = 5
STA_UNSYNC = 0x0040


@dataclass(frozen=True)
class Epoch:
    """The instant of mission time 0: nanoseconds since 1970 UTC, seconds that local time is ahead, and who says so."""

    utc_ns: int
    local_offset_s: int
    source: str

    def after(self, seconds: float) -> Epoch:
        """Of a clock that begins later by so much."""
        return replace(self, utc_ns=self.utc_ns + round(seconds * 1e9))

    def utc(self, mission_time: float) -> str:
        """ISO 8601, to the second."""
        return f"{_instant(self.utc_ns, mission_time, 0):%Y-%m-%dT%H:%M:%S}Z"

    def local(self, mission_time: float) -> str:
        """ISO 8601 with its distance from UTC, to the second."""
        return _instant(self.utc_ns, mission_time, self.local_offset_s).isoformat(timespec="seconds")

    def metadata(self) -> dict[str, str]:
        """For the log."""
        return {
            "utc_ns": str(self.utc_ns),
            "local_offset_s": str(self.local_offset_s),
            "source": self.source,
            "started_utc": self.utc(0.0),
        }


# Times of a log that does not say when it was made are mission time.
NO_EPOCH = Epoch(0, 0, "unknown")


def epoch_of(metadata: Mapping[str, str] | None) -> Epoch:
    """What a log says of its times."""
    try:
        assert metadata is not None
        return Epoch(int(metadata["utc_ns"]), int(metadata["local_offset_s"]), metadata["source"])
    except (AssertionError, KeyError, ValueError):  # an older log, or a damaged one
        return NO_EPOCH


def simulated_epoch(day: date | None, time_of_day_s: float, longitude_deg: float | None) -> Epoch:
    """`time_of_day_s`: local solar time at mission time 0. Without a longitude the field lies at Greenwich."""
    offset = round((longitude_deg or 0.0) * SOLAR_SECONDS_PER_DEGREE)
    midnight = datetime.combine(day or SIMULATED_DATE, datetime.min.time(), timezone.utc)
    utc = midnight + timedelta(seconds=time_of_day_s - offset)
    said = "the mission file's date" if day is not None else "the simulator's date"
    return Epoch(round(utc.timestamp()) * 10**9, offset, f"simulated: {said} and local solar time")


def system_epoch(mission_time: float) -> Epoch:
    """Of the system's clock, asked now, at `mission_time`."""
    utc_ns = time.time_ns() - round(mission_time * 1e9)
    offset = datetime.now().astimezone().utcoffset()
    seconds = 0 if offset is None else round(offset.total_seconds())
    return Epoch(utc_ns, seconds, f"system clock, {_quality()}")


def _quality() -> str:
    """Whether something sets the system's clock, as the kernel knows it."""
    structure = (ctypes.c_long * 64)()  # struct timex with modes 0: only asked; it is smaller than this
    try:
        state = ctypes.CDLL(ctypes.util.find_library("c")).adjtimex(structure)
    except (OSError, AttributeError):  # not Linux
        return "whether it is synchronised is not known"
    if state < 0:
        return "whether it is synchronised is not known"
    # struct timex: modes, offset, freq, maxerror, esterror, status …; modes and status are ints in a long's place.
    error_us, status = int(structure[4]), int(structure[5]) & 0xFFFF_FFFF
    if state == TIME_ERROR or status & STA_UNSYNC:
        return "not synchronised"
    return f"synchronised, estimated error {max(error_us, 1000) / 1e6:.3f} s"


def _instant(utc_ns: int, mission_time: float, offset_s: int) -> datetime:
    whole = (utc_ns + round(mission_time * 1e9)) // 10**9
    return datetime.fromtimestamp(whole, timezone(timedelta(seconds=offset_s)))
