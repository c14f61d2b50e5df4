"""What counts as evidence: thresholds, weights of looks, and what the camera has in clear view."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class EvidenceSettings:
    """report_threshold: probability of being a mine from which a place is an indication.

    suspect_threshold: the same for a suspected place. Distances in metres. The clear view is the part of base_link
    in which a mine would have been found: from clear_near to clear_far ahead, and `clear_side` + `clear_slope`·x
    to either side.
    """

    report_threshold: float = 0.3
    suspect_threshold: float = 0.3
    report_views: int = 4
    suspect_views: int = 3
    associate_within: float = 0.12
    create_from: float = 0.15
    near_range: float = 0.80
    far_weight: float = 0.5
    clear_near: float = 0.32
    clear_far: float = 0.92
    clear_side: float = 0.26
    clear_slope: float = 0.28
    shadow_half_width: float = 0.12
