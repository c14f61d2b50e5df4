"""Specification: an observer who searches finds what is stronger than all ground, and no more."""

from __future__ import annotations

import numpy as np
import pytest
from rover.detection.classifier import CLASSES
from rover.detection.ground.patch import LENGTH

from tools.evaluate.limit import STRENGTH, best_f1, searching_f1
from tools.train.ground.samples import Looks

BURIED, BACKGROUND = CLASSES.index("buried"), CLASSES.index("background")


def looks(of_mines: list[float], of_ground: list[float]) -> Looks:
    """One look at a field: candidates of these strengths on buried mines of one kelvin, and on bare ground."""
    mines, count = len(of_mines), len(of_mines) + len(of_ground)
    vectors = np.zeros((count, LENGTH), np.float32)
    vectors[:, STRENGTH] = [*of_mines, *of_ground]
    on_mine = np.arange(count) < mines
    return Looks(
        vectors=vectors,
        look=np.zeros(count, np.int64),
        mine=np.where(on_mine, np.arange(count), -1),
        kind=np.where(on_mine, BURIED, BACKGROUND),
        contrast=on_mine.astype(np.float32),
        radius=np.full(count, 0.055, np.float32),
        to_mine=np.where(on_mine, 0.0, 9.0).astype(np.float32),
        to_obstacle=np.full(count, 9.0, np.float32),
        seen=np.array([(0, number, BURIED, 1.0) for number in range(mines)], np.float32),
        field=np.zeros(1, np.int64),
    )


def test_mines_stronger_than_all_ground_are_told_without_error() -> None:
    assert searching_f1(looks([3.0, 4.0], [1.0, 2.0])) == pytest.approx(1.0)


def test_ground_as_strong_as_the_mines_costs_what_it_must() -> None:
    # Called are both mines and the one piece of ground between them: two hits, three calls, two mines.
    assert searching_f1(looks([3.0, 5.0], [1.0, 4.0])) == pytest.approx(0.8)


def test_more_places_to_confuse_mines_with_lower_the_best_f1() -> None:
    distances = np.array([2.0, 3.0, 4.0])
    assert best_f1(distances, 3, 30) < best_f1(distances, 3, 10) < 1.0
