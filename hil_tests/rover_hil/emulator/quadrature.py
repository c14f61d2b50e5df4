"""Quadrature edges on two pins: A leads B forwards, one edge a count (x4)."""

from __future__ import annotations

from collections.abc import Iterator

# Levels of A and B over count modulo 4.
LEVELS = ((False, False), (True, False), (True, True), (False, True))


def edges(count: int, target: int, start: int, end: int) -> Iterator[tuple[int, bool, bool]]:
    """(cycle, A, B) for each count from `count` to `target`, spread evenly inside [start, end)."""
    steps = abs(target - count)
    direction = 1 if target > count else -1
    for step in range(1, steps + 1):
        a, b = LEVELS[(count + direction * step) % 4]
        yield start + (2 * step - 1) * (end - start) // (2 * steps), a, b
