"""A mine of the truth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mine:
    """A mine of the truth: metres; `depth` is the soil above it; `contrast_k` is its signed peak at that hour."""

    id: int
    x: float
    y: float
    radius: float
    depth: float
    kind: str  # "surface" or "buried"
    contrast_k: float
