"""How the link has done, in figures for the report and the live status."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class LinkFigures:
    """Counts since the link came up; times in seconds. `quality` is the share of frames that arrived, both ways."""

    frames_received: int
    frames_sent: int
    lost: int
    checksum_errors: int
    malformed: int
    unknown: int
    bytes_received: int
    bytes_sent: int
    firmware_lost: int
    firmware_checksum_errors: int
    segments_sent: int
    segments_repeated: int
    segments_accepted: int
    segments_rejected: int
    runs_postponed: int
    clock_exchanges: int
    clock_error_bound: float
    clock_drift: float
    round_trip_median: float
    round_trip_p99: float

    @property
    def quality(self) -> float:
        """Share of frames that arrived, 0 to 1, of both directions."""
        lost = self.lost + self.firmware_lost
        total = self.frames_received + self.frames_sent + lost
        return 1.0 if total == 0 else 1.0 - lost / total

    def as_dict(self) -> dict[str, float]:
        """Plain values for JSON."""
        return {**asdict(self), "quality": self.quality}


def percentile(values: list[float], share: float) -> float:
    """The value below which `share` of `values` lies (nearest rank); 0 for none."""
    if not values:
        return 0.0
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
