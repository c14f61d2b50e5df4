"""A path as arc length: where along it a point is, how far beside it, and what lies ahead."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence

from rover.geometry import wrap_angle

Point = tuple[float, float]


class Polyline:
    """At least two distinct points, metres."""

    def __init__(self, points: Sequence[Point]) -> None:
        self.points = [(float(x), float(y)) for x, y in points]
        self._starts = [0.0]
        for a, b in zip(self.points[:-1], self.points[1:], strict=True):
            self._starts.append(self._starts[-1] + math.dist(a, b))

    @property
    def length(self) -> float:
        """Metres."""
        return self._starts[-1]

    def _edge(self, s: float) -> int:
        return min(max(bisect.bisect_right(self._starts, s) - 1, 0), len(self.points) - 2)

    def at(self, s: float) -> Point:
        """The point at arc length `s`; beyond the ends on the straight continuation."""
        edge = self._edge(s)
        (ax, ay), (bx, by) = self.points[edge], self.points[edge + 1]
        fraction = (s - self._starts[edge]) / (self._starts[edge + 1] - self._starts[edge])
        return ax + fraction * (bx - ax), ay + fraction * (by - ay)

    def heading(self, s: float) -> float:
        """Direction of the path at `s`."""
        edge = self._edge(s)
        (ax, ay), (bx, by) = self.points[edge], self.points[edge + 1]
        return math.atan2(by - ay, bx - ax)

    def turned(self, s: float) -> float:
        """Radians that curves before `s` have turned by: a polyline has none."""
        return 0.0

    def project(self, x: float, y: float, begin: float, end: float) -> tuple[float, float]:
        """(arc length, offset to the left) of the nearest point of the path between two arc lengths.

        On the last edge the arc length may pass the end, so that an overshoot shows.
        """
        best = (math.inf, 0.0, 0.0)
        for edge in range(self._edge(begin), self._edge(end) + 1):
            (ax, ay), (bx, by) = self.points[edge], self.points[edge + 1]
            length = self._starts[edge + 1] - self._starts[edge]
            ux, uy = (bx - ax) / length, (by - ay) / length
            along = (x - ax) * ux + (y - ay) * uy
            if edge < len(self.points) - 2:
                along = min(along, length)
            along = max(along, 0.0)
            offset = ux * (y - ay) - uy * (x - ax)
            gap = math.hypot(x - ax - along * ux, y - ay - along * uy)
            if gap < best[0]:
                best = (gap, self._starts[edge] + along, offset)
        return best[1], best[2]


def stretches(points: Sequence[Point], soft_corner: float, shortest: float) -> list[Polyline]:
    """The path cut at every corner sharper than `soft_corner` radians; edges shorter than `shortest` are dropped."""
    kept: list[Point] = []
    for point in points:
        if not kept or math.dist(kept[-1], point) >= shortest:
            kept.append((float(point[0]), float(point[1])))
    if len(kept) > 1 and math.dist(kept[-1], points[-1]) > 0.0:
        kept[-1] = (float(points[-1][0]), float(points[-1][1]))
    parts: list[list[Point]] = []
    last = 0.0
    for index in range(len(kept) - 1):
        a, b = kept[index], kept[index + 1]
        heading = math.atan2(b[1] - a[1], b[0] - a[0])
        if parts and abs(wrap_angle(heading - last)) <= soft_corner:
            parts[-1].append(b)
        else:
            parts.append([a, b])
        last = heading
    return [Polyline(part) for part in parts]
