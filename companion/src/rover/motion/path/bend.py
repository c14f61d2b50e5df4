"""Curves through runs of corners that are too near to each other to be rounded one by one.

The run is averaged over a sliding window (average.py), as wide as full speed needs and as tolerance and clearance let,
each place by itself: one narrow place costs something there and nowhere else. Between nodes, some to a window, the
heading is three parts of constant third derivative that take heading, curvature and its slope from node to node.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.average import Axis
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain
from rover.motion.path.speeds import lowest_within

Array = NDArray[np.float64]

# Windows that are tried, as shares of the widest, the widest last.
WINDOW_SHARES = tuple(0.75**number for number in range(12, -1, -1))
# Where it is allowed the window is no narrower than this share of the widest.
MIN_WINDOW_SHARE = 0.12
# The window changes by at most this along the path, metres a metre.
MAX_WINDOW_SLOPE = 0.5
# Share of the tolerance that windows are chosen with: smoothing their sizes widens some again.
TOLERANCE_SHARE = 0.95
# Distance of the places where windows are chosen, as a share of the widest, and the share of it that they differ by
# among many vertices: equal steps would meet stairs of the same period always at the same phase.
SAMPLE_SHARE, UNEVEN = 0.05, 0.5
# What the third derivative of heading is taken to be more between nodes than that of the average.
RIPPLE = 1.4
# Distance of nodes as a share of the window there, and at most.
NODE_SHARE, MAX_NODE_M = 0.25, 0.08
# So often the curves between nodes are fitted to them.
MAX_FITS = 2
# Windows that touch something are made narrower by this factor, so often at most.
NARROWER, MAX_NARROWINGS = 0.6, 6
# Chords that stand for the curve between two nodes where it is checked against the map.
CHORDS = 4
# While the speed changes on a curve: shares of the limits of heading for its curvature and for the change.
STEADY_SHARE, CHANGE_SHARE = 0.9, 0.8
# Of the limits of acceleration and jerk, what the speeds at the nodes may take: between them it is a little more.
SHARE = 0.97
# Curves without room are not driven, but have a speed, m/s.
SLOWEST_M_S = 0.02


@dataclass(frozen=True, eq=False)
class Run:
    """Points (N, 2) from where a bend begins to where it ends: the vertices between are those of a run of corners.

    `pinned`: whether the rover stands at the beginning and at the end. `tolerance`: metres that the bend may be off.
    `leg`: number of the leg on which it begins.
    """

    points: Array
    pinned: tuple[bool, bool]
    tolerance: float
    leg: int

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Run)
            and (self.pinned, self.tolerance, self.leg) == (other.pinned, other.tolerance, other.leg)
            and np.array_equal(self.points, other.points)
        )

    def __hash__(self) -> int:
        return hash((self.pinned, self.tolerance, self.leg))

    @cached_property
    def way(self) -> Array:
        """(N,): arc length of each point."""
        steps = np.diff(self.points, axis=0)
        return np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])


def widest_window(limits: DrivingLimits) -> float:
    """Half the window that a right angle needs to be driven at full speed, metres."""
    speed = limits.travel.speed
    curvature = min(limits.lateral / speed**2, limits.heading.speed / speed)
    return 3.2 / curvature


@dataclass(frozen=True, eq=False)
class Bend:
    """Curves, and between which distances along the run's points each leads, (N,). Speed 0: no room."""

    chain: Chain
    begin: Array
    end: Array


def bends(runs: Sequence[Run], limits: DrivingLimits, clearance: ClearanceMap | None, slack: float) -> list[Bend]:
    """A bend for each run. `slack`: metres that the footprint is grown by where it is checked."""
    if not runs:
        return []
    widest = widest_window(limits)
    axis, begins = _axis(runs, widest)
    places = [_places(run, widest) for run in runs]
    counts = [len(each) for each in places]
    u = np.concatenate([begin + each for begin, each in zip(begins, places, strict=True)])
    owner = np.repeat(np.arange(len(runs)), counts)
    tolerance = np.array([run.tolerance for run in runs])[owner]
    most = _most_window(runs, places, widest)
    window = _chosen(axis, u, tolerance * TOLERANCE_SHARE, most, widest, limits)
    for attempt in range(MAX_NARROWINGS + 1):
        smooth, slope = _smooth(u, window, most)
        nodes, node_owner = _nodes(u, smooth, counts)
        curves = _Curves(axis, nodes, node_owner, np.interp(nodes, u, smooth), np.interp(nodes, u, slope))
        touching = np.zeros(len(curves.begin), dtype=bool)
        if clearance is not None:
            touching = curves.touching(clearance, slack)
        if not touching.any() or attempt == MAX_NARROWINGS:
            break
        first = np.maximum(np.searchsorted(u, curves.begin[touching], side="left") - 1, 0)
        last = np.minimum(np.searchsorted(u, curves.end[touching], side="right") + 1, len(u))
        for low, high in zip(first.tolist(), last.tolist(), strict=True):
            window[low:high] = np.minimum(window[low:high], NARROWER * smooth[low:high])
    ends = np.searchsorted(curves.owner, np.arange(len(runs) + 1)).tolist()
    found = [(curves.begin[low:high], curves.end[low:high]) for low, high in itertools.pairwise(ends)]
    legs = [
        run.leg + np.searchsorted(run.way[1:-1], first - begin, side="right")
        for run, begin, (first, _) in zip(runs, begins, found, strict=True)
    ]
    chain = curves.chain(limits, clearance, touching, np.concatenate(legs))
    return [
        Bend(chain.between(low, high), first - begin, last - begin)
        for begin, (low, high), (first, last) in zip(begins, itertools.pairwise(ends), found, strict=True)
    ]


def _axis(runs: Sequence[Run], widest: float) -> tuple[Axis, list[float]]:
    """All runs on one axis, and where each begins."""
    gap = widest * (4.0 + 1.0 / MAX_WINDOW_SLOPE)
    begin = 0.0
    begins, along, points, at, change = [], [], [], [], []
    for run in runs:
        way = run.way
        turn = np.diff(np.diff(run.points, axis=0) / np.diff(way)[:, None], axis=0)
        vertices = way[1:-1]
        before = vertices < widest if run.pinned[0] else np.zeros(len(vertices), dtype=bool)
        behind = way[-1] - vertices < widest if run.pinned[1] else np.zeros(len(vertices), dtype=bool)
        begins.append(begin)
        along.append(begin + way)
        points.append(run.points)
        at += [begin - vertices[before][::-1], begin + vertices, begin + 2.0 * way[-1] - vertices[behind][::-1]]
        change += [-turn[before][::-1], turn, -turn[behind][::-1]]
        begin += float(way[-1]) + gap
    u = np.concatenate(along)
    legs = np.arange(len(u))
    legs[np.cumsum([len(each) for each in along]) - 1] -= 1
    return Axis(u, np.concatenate(points), legs, np.concatenate(at), np.concatenate(change)), begins


def _places(run: Run, widest: float) -> Array:
    """Arc lengths at which the window is chosen: steps, and the vertices where they are few."""
    way = run.way
    step = SAMPLE_SHARE * widest
    even = np.linspace(0.0, way[-1], max(3, math.ceil(way[-1] / step) + 1))
    if len(way) > len(even):
        even[1:-1] += UNEVEN * (even[1] - even[0]) * (np.arange(1, len(even) - 1) * 0.618 % 1.0 - 0.5)  # golden ratio
        return even
    found = np.union1d(even, way)
    keep = np.concatenate([[True], np.diff(found) > 1e-9])
    return np.asarray(found[keep], dtype=np.float64)


def _most_window(runs: Sequence[Run], places: list[Array], widest: float) -> Array:
    """The widest window at each place: where a bend joins a straight leg it must not reach beyond it."""
    found = []
    for run, at in zip(runs, places, strict=True):
        most = np.full(len(at), widest)
        if not run.pinned[0]:
            room = math.dist(run.points[0], run.points[1])
            most = np.minimum(most, np.maximum(room, room + MAX_WINDOW_SLOPE * (at - room)))
        if not run.pinned[1]:
            room, left = math.dist(run.points[-1], run.points[-2]), at[-1] - at
            most = np.minimum(most, np.maximum(room, room + MAX_WINDOW_SLOPE * (left - room)))
        found.append(most)
    return np.concatenate(found)


def _chosen(axis: Axis, u: Array, tolerance: Array, most: Array, widest: float, limits: DrivingLimits) -> Array:
    """The window at each place: the narrowest with which all that it reaches may be driven at full speed, or the
    fastest within tolerance; wider where a neighbour wants that, which it may change to by MAX_WINDOW_SLOPE."""
    best, fastest = np.minimum(most, WINDOW_SHARES[0] * widest), np.zeros(len(u))
    allowed = best.copy()
    full = float(limits.curve_speed(np.zeros(1), np.zeros(1), np.zeros(1))[0])
    spacing = np.max(np.diff(u)[np.diff(u) < widest], initial=0.0)
    for share in WINDOW_SHARES:
        window = np.minimum(share * widest, most)
        off, curvature, rate, third = axis.bending(u, window)
        speed = limits.curve_speed(curvature, rate, RIPPLE * third)
        near = off <= tolerance
        allowed[near] = window[near]
        reach = np.maximum(window, 1.01 * spacing)
        # A narrower window may be slow between places.
        speed = lowest_within(u, speed, u - reach, u + reach) * np.minimum(window / (2.0 * spacing), 1.0)
        better = near & (speed > 1.005 * fastest)
        best[better], fastest[better] = window[better], speed[better]
        if (fastest >= 0.999 * full).all():
            break
    # Straight parts want no window: there it is as wide as it may be, so that nodes are few.
    best = np.maximum(best, np.minimum(allowed, MIN_WINDOW_SHARE * widest))
    wanted = -_eased(u, -best)
    return np.minimum(wanted, _eased(u, np.maximum(allowed, best)))


def _eased(u: Array, values: Array) -> Array:
    """The largest function below the values that changes by at most MAX_WINDOW_SLOPE."""
    slope = MAX_WINDOW_SLOPE
    forward = np.minimum.accumulate(values - slope * u) + slope * u
    return np.asarray(np.minimum.accumulate((forward + slope * u)[::-1])[::-1] - slope * u, dtype=np.float64)


def _smooth(u: Array, window: Array, most: Array) -> tuple[Array, Array]:
    """The windows without steps, nowhere much wider, and their slope."""
    capped = _eased(u, window)
    for _ in range(2):
        area = np.concatenate([[0.0], np.cumsum(np.diff(u) * (capped[1:] + capped[:-1]) / 2.0)])
        reach = 0.25 * capped
        low, high = np.maximum(u - reach, u[0]), np.minimum(u + reach, u[-1])
        capped = (np.interp(high, u, area) - np.interp(low, u, area)) / (high - low)
    capped = np.minimum(capped, most)
    return capped, np.gradient(capped, u)


def _nodes(u: Array, window: Array, counts: list[int]) -> tuple[Array, NDArray[np.int64]]:
    """Nodes along each run, NODE_SHARE of the window apart, and the run of each."""
    density = 1.0 / np.minimum(NODE_SHARE * window, MAX_NODE_M)
    found, owners = [], []
    first = 0
    for run, count in enumerate(counts):
        at, dense = u[first : first + count], density[first : first + count]
        number = np.concatenate([[0.0], np.cumsum(np.diff(at) * (dense[1:] + dense[:-1]) / 2.0)])
        pieces = max(2, math.ceil(number[-1]))
        found.append(np.interp(np.linspace(0.0, number[-1], pieces + 1), number, at))
        owners.append(np.full(pieces + 1, run))
        first += count
    return np.concatenate(found), np.concatenate(owners)


class _Curves:
    """Three parts of constant third derivative between each two neighbours of the nodes."""

    def __init__(self, axis: Axis, u: Array, owner: NDArray[np.int64], window: Array, slope: Array) -> None:
        value, d1 = axis.at(u, window, slope)
        heading = np.arctan2(d1[:, 1], d1[:, 0])
        inner = owner[1:] == owner[:-1]
        self.owner = owner[:-1][inner]
        self.begin, self.end = u[:-1][inner], u[1:][inner]
        self.at, self.heading = value[:-1][inner], heading[:-1][inner]
        self.angle = np.mod(np.diff(heading)[inner] + math.pi, 2.0 * math.pi) - math.pi
        chord = np.hypot(*np.diff(value, axis=0)[inner].T)
        self.length = np.maximum(chord * (1.0 + self.angle**2 / 24.0), 1e-6)
        self._fit(np.diff(value, axis=0)[inner])
        self.thirds = self._thirds()

    def _fit(self, steps: Array) -> None:
        """Headings at the nodes and lengths such that each curve leads from node to node, by `steps` (N, 2)."""
        chord, direction = np.hypot(steps[:, 0], steps[:, 1]), np.arctan2(steps[:, 1], steps[:, 0])
        joined = np.append(self.owner[1:] == self.owner[:-1], False)
        ends = np.append(np.flatnonzero(~joined[:-1]), len(joined) - 1) + 1
        for number in range(MAX_FITS):
            self.k0, self.k1, self.r0, self.r1 = rover_native.heading_splines(self.length, self.angle, ends).T
            made = self._points()[:, -1] - self.at
            self.length *= chord / np.maximum(np.hypot(made[:, 0], made[:, 1]), 1e-9)
            if number == MAX_FITS - 1:
                break
            off = direction - np.arctan2(made[:, 1], made[:, 0])
            off = np.mod(off + math.pi, 2.0 * math.pi) - math.pi
            turn = np.where(joined, (off + np.append(off[1:], 0.0)) / 2.0, 0.0)
            self.heading[1:] += turn[:-1]
            self.angle += turn - np.concatenate([[0.0], turn[:-1]])

    def _thirds(self) -> Array:
        """(N, 3): the third derivatives that lead from node to node, by solving for the state at the end."""
        h = self.length / 3.0
        a = (self.r1 - self.r0) / h
        b = (self.k1 - self.k0 - 3.0 * h * self.r0) / h**2
        c = (self.angle - 3.0 * h * self.k0 - 4.5 * h**2 * self.r0) / h**3
        first = c + a / 3.0 - b
        second = b - 0.5 * a - 2.0 * first
        return np.column_stack([first, second, a - first - second])

    def _states(self) -> tuple[Array, Array, Array]:
        """(N, 4) each: radians turned, curvature and its slope at the ends of the parts."""
        h, thirds = self.length / 3.0, self._thirds()
        turned, first, second = [np.zeros(len(h))], [self.k0], [self.r0]
        for part in range(3):
            third = thirds[:, part]
            turned.append(turned[-1] + h * (first[-1] + h * (second[-1] / 2.0 + h * third / 6.0)))
            first.append(first[-1] + h * (second[-1] + h * third / 2.0))
            second.append(second[-1] + h * third)
        return np.column_stack(turned), np.column_stack(first), np.column_stack(second)

    def _points(self) -> Array:
        """(N, CHORDS + 1, 2): points along each curve at equal distances."""
        curves = np.column_stack([self.at, self.heading, self.length, self.k0, self.r0, self._thirds()])
        return rover_native.curve_points(curves, CHORDS).reshape(len(curves), CHORDS + 1, 2)

    def peaks(self) -> tuple[Array, Array, Array]:
        """Largest magnitude of curvature, of its slope and of its second derivative on each curve."""
        _, first, second = self._states()
        h, most = self.length / 3.0, np.abs(first).max(axis=1)
        for part in range(3):
            third = self.thirds[:, part]
            at = np.clip(np.divide(-second[:, part], third, out=np.zeros(len(h)), where=third != 0.0), 0.0, h)
            most = np.maximum(most, np.abs(first[:, part] + at * (second[:, part] + at * third / 2.0)))
        return most, np.abs(second).max(axis=1), np.abs(self.thirds).max(axis=1)

    def inside(self) -> Array:
        """Arc length from the middle of each curve to the nearer end of its run, metres."""
        way = np.cumsum(self.length) - self.length / 2.0
        ends = np.flatnonzero(np.diff(np.concatenate([[-1], self.owner, [self.owner[-1] + 1]])))
        bounds = np.concatenate([[0.0], np.cumsum(self.length)])[ends]
        run = np.searchsorted(ends, np.arange(len(way)), side="right") - 1
        return np.asarray(np.minimum(way - bounds[run], bounds[run + 1] - way), dtype=np.float64)

    def touching(self, clearance: ClearanceMap, slack: float) -> NDArray[np.bool_]:
        """True for curves along which the footprint can't be shown to be free."""
        points = self._points()
        bulge = self.peaks()[0] * (self.length / CHORDS) ** 2 / 8.0
        a, b = points[:, :-1].reshape(-1, 2), points[:, 1:].reshape(-1, 2)
        clear = clearance.swept(a, b, np.repeat(bulge + slack, CHORDS))
        return np.asarray(~clear.reshape(-1, CHORDS).all(axis=1), dtype=np.bool_)

    def chain(
        self,
        limits: DrivingLimits,
        clearance: ClearanceMap | None,
        touching: NDArray[np.bool_],
        legs: NDArray[np.int64],
    ) -> Chain:
        """The curves with their speeds, 0 where they touch something. `legs` (N,): on which each begins."""
        curvature, rate, third = self.peaks()
        bound = np.minimum(limits.travel.speed, limits.sight_speed(curvature))
        if clearance is not None and limits.clearance_time > 0.0:
            margin = clearance.margin(self._points().reshape(-1, 2)).reshape(-1, CHORDS + 1).min(axis=1)
            bound = np.minimum(bound, limits.clearance_speed(margin))
        speed = np.minimum(limits.curve_speed(curvature, rate, third), bound)
        changing = np.minimum(speed, limits.shared(STEADY_SHARE).curve_speed(curvature, rate, third))
        tight = np.maximum(curvature, 1e-9)
        swing = CHANGE_SHARE * limits.heading.jerk / 3.0 / np.maximum(rate * changing, 1e-9)
        acceleration = np.minimum(CHANGE_SHARE * limits.heading.acceleration / tight, swing)
        acceleration = np.minimum(limits.travel.acceleration, acceleration)
        jerk = np.minimum(limits.travel.jerk, CHANGE_SHARE * limits.heading.jerk / tight)
        # Towards the ends of a bend, where the acceleration is zero, it can't be more than its jerk leaves time for.
        inside = self.inside()
        acceleration = np.minimum(acceleration, jerk * inside / np.maximum(changing, 1e-9))
        change = np.column_stack([changing, acceleration, jerk])
        none = np.zeros_like(curvature)
        most = np.maximum(np.minimum(limits.curve_speed(curvature, none, none), bound), SLOWEST_M_S)
        return Chain(
            self.at, self.heading, self.length, self.angle, np.where(touching, 0.0, speed), bound, self.thirds,
            self.k0, self.r0, legs, most, np.full(len(most), SHARE), change,
        )  # fmt: skip
