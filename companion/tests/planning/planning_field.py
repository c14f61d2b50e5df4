"""The paper's field of section 4.4, as the project fixes it."""

from __future__ import annotations

from rover.planning import CircleField

OBSTACLES = [
    [2.0, 1.5, 0.20],
    [1.3, 1.1, 0.15],
    [0.6, 0.7, 0.15],
    [2.6, 1.9, 0.15],
    [0.8, 1.8, 0.20],
    [1.5, 2.0, 0.15],
    [2.5, 3.1, 0.20],
    [1.6, 3.0, 0.18],
    [0.7, 2.9, 0.20],
    [0.4, 3.6, 0.10],
]
WIDTH, HEIGHT = 3.0, 4.0
START = (2.0, 0.5)
GOALS = [(2.0, 2.5), (1.2, 3.5)]
RADIUS = 0.15
# Visibility graph over 48-sided circles.
OPTIMUM = 3.580


def field() -> CircleField:
    return CircleField(WIDTH, HEIGHT, OBSTACLES)
