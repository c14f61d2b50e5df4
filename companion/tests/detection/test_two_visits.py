"""Specification: what two visits at two hours say together of ground that neither shows alone."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.fusion import Evidence
from rover.detection.place import Place
from rover.detection.second_look import likeness, peaks, sign_at
from rover.detection.two_visits import REPORT, compare
from rover.geometry import Pose2

RESOLUTION = 0.02
HOURS = (5.0, 14.0)  # colder, warmer than the soil
MINE = (2.1, 1.5)  # x, y in metres
# Change of all ground from the first visit to the second, kelvin.
RISE_K = 20.0


def ground(seed: int, contrast: tuple[float, float], plain: float = 0.35) -> tuple[np.ndarray, np.ndarray]:
    """Two mosaics of 4 m with the same clutter, twice as strong by day, 0.05 K of change, and a mine."""
    rng = np.random.default_rng(seed)
    side = round(4.0 / RESOLUTION)

    def noise(sigma_m: float, rms: float) -> np.ndarray:
        layer = cv2.GaussianBlur(rng.standard_normal((side, side)).astype(np.float32), (0, 0), sigma_m / RESOLUTION)
        return layer * np.float32(rms / layer.std())

    y, x = (np.mgrid[0:side, 0:side] + 0.5) * RESOLUTION
    spot = np.exp(-0.5 * ((x - MINE[0]) ** 2 + (y - MINE[1]) ** 2) / 0.05**2).astype(np.float32)
    clutter = noise(0.03, plain) + noise(0.1, plain)
    night, day = (
        np.float32(283.0 + rise) + share * clutter + noise(0.03, 0.05) + np.float32(k) * spot
        for rise, share, k in ((0.0, 0.5, contrast[0]), (RISE_K, 1.0, contrast[1]))
    )
    return night, day


def best_near_the_mine(spots: np.ndarray) -> float:
    apart = np.hypot(spots[:, 0] - MINE[0], spots[:, 1] - MINE[1])
    return float(spots[apart < 0.08, 2].max(initial=0.0))


@pytest.mark.parametrize("seed", range(5))
def test_a_mine_that_neither_hour_shows_is_found_by_both(seed: int) -> None:
    night, day = ground(seed, (-0.35, 0.6))
    alone = [
        best_near_the_mine(peaks(likeness(kelvin, RESOLUTION, sign_at(hour)), RESOLUTION, 1.0))
        for kelvin, hour in zip((night, day), HOURS, strict=True)
    ]
    spots = compare(night, day, HOURS, RESOLUTION).spots()
    assert max(alone) < REPORT
    assert best_near_the_mine(spots) > REPORT
    assert len(spots) == 1


@pytest.mark.parametrize("seed", range(3))
def test_plain_ground_varies_by_no_more_than_one_and_reports_nothing(seed: int) -> None:
    two = compare(*ground(seed, (0.0, 0.0)), HOURS, RESOLUTION)
    assert 0.3 < float(two.likeness.std()) < 1.2
    assert len(two.spots()) == 0


def test_warm_at_night_and_by_day_is_no_mine() -> None:
    night, day = ground(1, (0.6, 0.6))
    assert best_near_the_mine(compare(night, day, HOURS, RESOLUTION).spots(1.0)) < REPORT


def test_where_one_visit_saw_nothing_the_other_speaks() -> None:
    night, day = ground(2, (-1.2, 3.0))
    night[:, 60:160] = np.nan
    two = compare(night, day, HOURS, RESOLUTION)
    assert best_near_the_mine(two.spots()) > REPORT
    at = two.at(*MINE)
    assert np.isnan(at.first)
    assert at.second > 0.5
    assert at.inertia is None


def test_apparent_thermal_inertia_is_lower_above_a_mine() -> None:
    two = compare(*ground(3, (-1.0, 2.0)), HOURS, RESOLUTION)
    above, beside = two.at(*MINE), two.at(0.8, 0.8)
    assert above.inertia is not None
    assert beside.inertia is not None
    assert above.inertia == pytest.approx(RISE_K / (RISE_K + 3.0), abs=0.03)
    assert beside.inertia == pytest.approx(1.0, abs=0.04)
    assert above.p > 0.9 > 0.1 > beside.p


def test_the_difference_holds_nothing_that_all_ground_has_in_common() -> None:
    difference = compare(*ground(4, (0.0, 0.0)), HOURS, RESOLUTION).difference
    assert abs(float(np.median(difference))) < 1e-3


def test_no_look_of_the_second_visit_drops_what_the_first_has_reported() -> None:
    evidence = Evidence(EvidenceSettings())
    reported = {"obstacle": 0.0, "surface": 0.1, "buried": 0.8, "background": 0.1}
    evidence.restore([Place(7, 0.6, 0.0, 0.0, 0.0, earlier=reported), Place(9, 0.6, 0.3, 0.0, 0.0)], 10)
    for step in range(40):
        pose = Pose2(0.0, 0.02 * step % 0.3, 0.0)
        evidence.update([], pose, 1e-6 * np.eye(3), 0.1 * step)
    assert [(place.id, place.indication, place.suspected) for place in evidence.places] == [(7, True, True)]
    assert not evidence.places[0].is_found(evidence.settings)
    assert evidence.places[0].reported_as == ("buried", 0.8)
    assert evidence.next_place == 10


def test_what_only_both_together_report_gets_the_next_number() -> None:
    evidence = Evidence(EvidenceSettings())
    evidence.restore([], 4)
    place = evidence.report(1.0, 2.0, 0.03, 60.0, 0, 0.75)
    assert (place.id, place.indication, place.reported_as) == (4, True, ("buried", 0.75))
    assert evidence.next_place == 5


def test_a_kind_that_one_visit_was_sure_of_is_not_made_less_sure_by_the_other() -> None:
    sure = {"obstacle": 0.0, "surface": 0.99, "buried": 0.005, "background": 0.005}
    torn = {"obstacle": 0.0, "surface": 0.65, "buried": 0.349, "background": 0.001}
    assert Place(1, 0.0, 0.0, 0.0, 0.0, p=torn, earlier=sure).reported_as == ("surface", 0.99)
    assert Place(1, 0.0, 0.0, 0.0, 0.0, p=sure, earlier=torn).reported_as == ("surface", 0.99)
