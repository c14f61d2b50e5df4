"""The pairs of landmines that were judged by eye: those that overlap by half are registered, and none wrongly."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from rover.vision.registration.register import Registration, register

from tools.bench.vision.pairs import Judged, judged_pairs

EVERY = 6


@pytest.fixture(scope="module")
def rover_data() -> Path:
    """The folder of real pictures."""
    if "ROVER_DATA" not in os.environ:
        pytest.skip("ROVER_DATA is not set: no real pictures")
    return Path(os.environ["ROVER_DATA"])


@pytest.fixture(scope="module")
def registered(rover_data: Path) -> list[tuple[Judged, Registration]]:
    """Every sixth pair of the list."""
    return [(pair, register(*pair.pictures(rover_data))) for pair in judged_pairs()[::EVERY]]


def test_the_list_holds_80_pairs_that_overlap_by_half_and_others_that_do_not() -> None:
    pairs = judged_pairs()
    counted = Counter(pair.overlap for pair in pairs)
    assert counted["over"] >= 80
    assert counted["less"] + counted["none"] >= 40
    assert set(counted) == {"over", "less", "none"}
    assert len({(pair.a, pair.b) for pair in pairs}) == len(pairs)


@pytest.mark.slow
def test_pairs_that_overlap_by_over_half_are_registered(registered: list[tuple[Judged, Registration]]) -> None:
    over = [(pair.a, found.status) for pair, found in registered if pair.overlap == "over"]
    assert len(over) >= 10
    assert [name for name, status in over if status != "ok"] == []


def test_none_is_wrong(registered: list[tuple[Judged, Registration]]) -> None:
    assert [pair.a for pair, found in registered if pair.wrong(found.homography, (640, 640))] == []


def test_a_homography_beside_the_one_found_right_counts_as_wrong() -> None:
    pair = Judged("a", "b", "over", np.array([[0.0, 0.0], [640.0, 0.0], [640.0, 640.0], [0.0, 640.0]]))
    aside = np.array([[1.0, 0.0, 11.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert not pair.wrong(np.eye(3), (640, 640))
    assert pair.wrong(aside, (640, 640))
    assert Judged("a", "b", "none", None).wrong(np.eye(3), (640, 640))
