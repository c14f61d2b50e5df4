"""What a path is made of once it can be driven: lines and curves, and stretches of them without a stop.

Along a curve the heading is a cubic spline of arc length: parts of constant third derivative. Driven at a constant
speed v each part is exactly one constant-jerk segment of heading, with jerk v³ times that derivative.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from rover.vehicle import Limits

Array = NDArray[np.float64]

_GAUSS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, slots=True)
class Piece:
    """A straight line (no `parts`) or a curve that turns by `angle` radians, left positive; metres.

    Begins at (x, y) in `heading`. `speed`: the most that it may be driven at; `bound`: what clearance and sight alone
    allow, whatever the limits of the axes. `parts`: (length, third derivative of heading over arc length) of each part
    of a curve, which begins with `curvature` (1/m) and its slope `curvature_rate` (1/m²). `change`: limits of a change
    of speed on a curve; None where it must be driven at one speed. `leg`: of the polyline, on which the piece begins.
    """

    x: float
    y: float
    heading: float
    length: float
    angle: float
    speed: float
    bound: float
    parts: tuple[tuple[float, float], ...] = ()
    curvature: float = 0.0
    curvature_rate: float = 0.0
    change: Limits | None = None
    leg: int = 0

    def turning(self, s: float) -> tuple[float, float, float]:
        """Radians turned since the beginning, curvature (1/m) and its slope (1/m²) at arc length `s`."""
        turned, first, second = 0.0, self.curvature, self.curvature_rate
        for length, third in self.parts:
            t = min(s, length)
            turned += t * (first + t * (second / 2.0 + t * third / 6.0))
            first += t * (second + t * third / 2.0)
            second += t * third
            s -= t
            if s <= 0.0:
                break
        return turned, first, second

    def part_at(self, s: float) -> tuple[float, float]:
        """Third derivative of heading from arc length `s` on, and the arc length up to which it stays so."""
        end, third = 0.0, 0.0
        for length, third in self.parts:
            end += length
            if s < end:
                return third, end
        return third, self.length

    def points(self, count: int) -> Array:
        """(count + 1, 2): the ends of `count` equal parts."""
        if not self.parts:
            way = np.linspace(0.0, self.length, count + 1)
            return np.column_stack([self.x + way * np.cos(self.heading), self.y + way * np.sin(self.heading)])
        step = self.length / count
        at = (np.arange(count)[:, None] + (_GAUSS + 1.0) / 2.0) * step
        ends = np.cumsum([length for length, _ in self.parts])
        starts = np.concatenate([[0.0], ends[:-1]])
        states = np.array([(*self.turning(start), third) for start, (_, third) in zip(starts, self.parts, strict=True)])
        part = np.minimum(np.searchsorted(ends, at, side="right"), len(self.parts) - 1)
        turned, first, second, third = states[part].transpose(2, 0, 1)
        r = at - starts[part]
        heading = self.heading + turned + r * (first + r * (second / 2.0 + r * third / 6.0))
        steps = np.stack([np.cos(heading) @ _GAUSS_WEIGHTS, np.sin(heading) @ _GAUSS_WEIGHTS], axis=-1) * (step / 2.0)
        offsets: Array = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        points: Array = offsets + np.array([self.x, self.y])
        return points


@dataclass(frozen=True, eq=False)
class Chain:
    """N curves from node to node of a bend, along which the speed changes, as arrays; metres, radians.

    `at` (N, 2), `heading`, `length`, `angle`, `speed`, `bound`, `leg` (N,) as those of a Piece; `thirds` (N, 3): third
    derivative of heading on three equal parts of each; `curvature`, `slope` (N,) at the beginning of each.
    `most`, `share` (N,): the most speed on each, and the share of the limits of acceleration and jerk.
    `change` (N, 3): limits of speed, acceleration and jerk for who drives curve by curve.
    """

    at: Array
    heading: Array
    length: Array
    angle: Array
    speed: Array
    bound: Array
    thirds: Array
    curvature: Array
    slope: Array
    leg: NDArray[np.int64]
    most: Array
    share: Array
    change: Array

    def __len__(self) -> int:
        return len(self.length)

    def between(self, low: int, high: int) -> Chain:
        """The curves from `low` up to `high`."""
        return Chain(*(getattr(self, field.name)[low:high] for field in fields(self)))

    @cached_property
    def nodes(self) -> tuple[Array, Array]:
        """Curvature and its slope at the beginning of each curve and at the end of the last, (N + 1,) each."""
        curvature, slope, h = float(self.curvature[-1]), float(self.slope[-1]), float(self.length[-1]) / 3.0
        for third in self.thirds[-1].tolist():
            curvature += h * (slope + h * third / 2.0)
            slope += h * third
        return np.append(self.curvature, curvature), np.append(self.slope, slope)

    def pieces(self) -> list[Piece]:
        """The curves one by one."""
        columns = (
            self.at[:, 0], self.at[:, 1], self.heading, self.length, self.angle, self.speed, self.bound, self.thirds,
            self.curvature, self.slope, self.change, self.leg,
        )  # fmt: skip
        found = []
        for row in zip(*(column.tolist() for column in columns), strict=True):
            x, y, heading, length, angle, speed, bound, thirds, curvature, slope, change, leg = row
            parts = tuple((length / 3.0, third) for third in thirds)
            found.append(
                Piece(x, y, heading, length, angle, speed, bound, parts, curvature, slope, Limits(*change), leg)
            )
        return found


@dataclass(frozen=True)
class Stretch:
    """Lines, corners and bends driven without a stop; before it the rover turns on the spot to the heading of the
    first."""

    parts: tuple[Piece | Chain, ...]

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """All lines and curves one by one."""
        return tuple(piece for part in self.parts for piece in (part.pieces() if isinstance(part, Chain) else (part,)))

    @property
    def begin(self) -> tuple[float, float, float]:
        """x, y and heading at the beginning."""
        first = self.parts[0]
        if isinstance(first, Piece):
            return first.x, first.y, first.heading
        x, y = first.at[0].tolist()
        return x, y, float(first.heading[0])

    @property
    def length(self) -> float:
        """Metres."""
        return float(sum(np.sum(part.length) for part in self.parts))
