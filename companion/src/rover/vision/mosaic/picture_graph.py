"""Many pictures of one plane, each with its place in one mosaic: a graph of registered pairs, solved as a whole.

Chaining would add up every pair's error; here all pairs pull at once, also those that close a loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.homography import apply_homography
from rover.vision.registration.refine import RefineSettings, follow, lay, strongest_corners
from rover.vision.registration.register import (
    Picture,
    Prepared,
    RegistrationSettings,
    prepare,
    register_prepared,
)

Points = NDArray[np.float64]
Progress = Callable[[int, int], None]
RIGHT, DOWN = np.array([1.0, 0.0]), np.array([0.0, 1.0])


@dataclass(frozen=True)
class GraphSettings:
    """reach: each picture is registered with so many before it, and with all if there are at most `few`.

    overlap: share of a picture that must lie on another, by the first solution, for that pair to be tried too.
    registration: as of a pair by itself, but not to the last fraction of a pixel, for which there are the ties.
    corners: points that tie a pair; spacing: least distance between them, a share of the picture's width, so that a
    textured thing before the wall does not take them all. scales_px: residual at which a tie begins to count less
    (Cauchy), solution after solution: the first asks what most of the graph agrees with, the last for exactness.
    """

    registration: RegistrationSettings = field(default_factory=lambda: RegistrationSettings(fine=(1,)))
    follow: RefineSettings = field(default_factory=lambda: RefineSettings(window=21, halvings=2))
    reach: int = 3
    few: int = 10
    overlap: float = 0.4
    corners: int = 120
    spacing: float = 0.05
    scales_px: tuple[float, ...] = (8.0, 2.5, 1.0)
    iterations: int = 8


@dataclass(frozen=True, eq=False)
class Tie:
    """Points (N, 2) of picture a and where they lie in picture b, pixels of each."""

    a: int
    b: int
    in_a: Points
    in_b: Points


@dataclass(frozen=True, eq=False)
class Placement:
    """homographies: number of the picture → (3, 3) to the pixels of the reference picture. rmse_px: of all ties."""

    reference: int
    homographies: dict[int, Points]
    rmse_px: float


def place_pictures(pictures: Sequence[Picture], settings: GraphSettings, progress: Progress | None = None) -> Placement:
    """Where each picture lies; the largest group that hangs together is placed, the rest left out."""
    nodes: list[Prepared] = []
    first: dict[tuple[int, int], Points] = {}
    for number, picture in enumerate(pictures):
        nodes.append(prepare(picture, settings.registration))
        reach = number if len(pictures) <= settings.few else settings.reach
        for other in range(number - 1, max(0, number - reach) - 1, -1):
            is_tied = any(b == number for _, b in first)
            _try(nodes, other, number, first, settings, use_blobs=not is_tied)
        if progress is not None:
            progress(number + 1, len(pictures))
    group = _largest_group(len(pictures), first)
    reference = _middle(group, first)
    homographies = _chained(reference, group, first)
    for a, b in _overlapping(homographies, nodes, first, settings):
        _try(nodes, a, b, first, settings)
    ties = [tie for (a, b) in sorted(first) if a in homographies for tie in _tie(nodes, a, b, first[a, b], settings)]
    homographies = solve(homographies, reference, ties, settings)
    return Placement(reference, homographies, rmse_of(homographies, ties, settings.scales_px[-1]))


def _try(
    nodes: list[Prepared],
    a: int,
    b: int,
    found: dict[tuple[int, int], Points],
    settings: GraphSettings,
    use_blobs: bool = False,
) -> None:
    """Registers a pair. Blobs cost as much as all the rest: they are for a picture that is tied to none yet."""
    asked = replace(settings.registration, use_blobs=use_blobs)
    homography = register_prepared(nodes[a], nodes[b], asked).homography
    if homography is not None:
        found[a, b] = homography


def _largest_group(count: int, edges: dict[tuple[int, int], Points]) -> list[int]:
    group_of = list(range(count))

    def root(node: int) -> int:
        while group_of[node] != node:
            node = group_of[node]
        return node

    for a, b in edges:
        group_of[max(root(a), root(b))] = min(root(a), root(b))
    roots = [root(node) for node in range(count)]
    best = max(sorted(set(roots)), key=roots.count)
    return [node for node in range(count) if roots[node] == best]


def _middle(group: list[int], edges: dict[tuple[int, int], Points]) -> int:
    """The picture from which the farthest of its group is reached in the fewest steps: it distorts the others least."""

    def farthest(start: int) -> int:
        steps, ring, seen = 0, {start}, {start}
        while True:
            ring = {b for pair in edges for a, b in (pair, pair[::-1]) if a in ring} - seen
            if not ring:
                return steps
            seen |= ring
            steps += 1

    return min(group, key=lambda node: (farthest(node), node))


def _chained(reference: int, group: list[int], edges: dict[tuple[int, int], Points]) -> dict[int, Points]:
    """A first solution: from picture to picture outwards from the reference, by the fewest steps."""
    placed = {reference: np.eye(3)}
    while len(placed) < len(group):
        reached: dict[int, Points] = {}
        for (a, b), homography in sorted(edges.items()):
            if b in placed and a not in placed and a not in reached:
                reached[a] = _normal(placed[b] @ homography)
            elif a in placed and b not in placed and b not in reached:
                reached[b] = _normal(placed[a] @ np.linalg.inv(homography))
        placed |= reached
    return placed


def _normal(homography: Points) -> Points:
    normal: Points = homography / homography[2, 2]
    return normal


def _overlapping(
    homographies: dict[int, Points],
    nodes: list[Prepared],
    tried: dict[tuple[int, int], Points],
    settings: GraphSettings,
) -> list[tuple[int, int]]:
    """Pairs not registered yet that lie on each other for a good part."""
    pairs = []
    for a in homographies:
        height, width = nodes[a].sharp.shape
        grid = np.stack(np.meshgrid(np.linspace(0, width, 9), np.linspace(0, height, 9)), axis=-1).reshape(-1, 2)
        for b in homographies:
            if a < b and (a, b) not in tried:
                there = apply_homography(np.linalg.inv(homographies[b]) @ homographies[a], grid)
                inside = ((there >= 0) & (there <= nodes[b].sharp.shape[::-1])).all(axis=1)
                if inside.mean() > settings.overlap:
                    pairs.append((a, b))
    return pairs


def _tie(nodes: list[Prepared], a: int, b: int, homography: Points, settings: GraphSettings) -> list[Tie]:
    """Corners followed from a into b; nothing when too few come back."""
    laid = lay(nodes[a].sharp, nodes[b].sharp, homography)
    if laid is None:
        return []
    spacing = settings.spacing * laid[0].shape[1]
    start = strongest_corners(laid[0], settings.corners, settings.follow.quality, spacing, laid[1])
    there, good = follow(laid[0], nodes[b].sharp, start, settings.follow)
    if good.sum() < 8:
        return []
    back = np.asarray(np.linalg.inv(homography), np.float64)
    return [Tie(a, b, apply_homography(back, start[good]), there[good])]


def solve(
    homographies: dict[int, Points], reference: int, ties: list[Tie], settings: GraphSettings
) -> dict[int, Points]:
    """All homographies but the reference's moved so that tied points meet in the mosaic.

    Some pictures mostly show something before the wall, and their ties agree on that: what most of the graph agrees
    with is found while residuals of many pixels still count (graduated non-convexity), and made exact afterwards.
    """
    for scale_px in settings.scales_px:
        homographies = _descend(homographies, reference, ties, scale_px, settings.iterations)
    return homographies


def _descend(
    homographies: dict[int, Points], reference: int, ties: list[Tie], scale_px: float, iterations: int
) -> dict[int, Points]:
    """Gauss-Newton, damped; a tie counts less from a residual of `scale_px` on (Cauchy)."""
    free = [number for number in sorted(homographies) if number != reference]
    if not free or not ties:
        return homographies
    row = {number: index for index, number in enumerate(free)}
    cost = _cost(homographies, ties, scale_px)
    damping = 1e-4
    for _ in range(iterations):
        step = _step(homographies, row, ties, scale_px, damping)
        moved = {n: _normal((np.eye(3) + step[row[n]]) @ h) if n in row else h for n, h in homographies.items()}
        new = _cost(moved, ties, scale_px)
        if new < cost:
            done = cost - new < 1e-6 * cost
            homographies, cost, damping = moved, new, damping / 5
            if done:
                break
        else:
            damping *= 10
    return homographies


def _meeting(homographies: dict[int, Points], tie: Tie) -> tuple[Points, Points, Points]:
    """Both sides of a tie in the mosaic (N, 2), and how many mosaic pixels a pixel of picture a is there (N,)."""
    in_a, in_b = apply_homography(homographies[tie.a], tie.in_a), apply_homography(homographies[tie.b], tie.in_b)
    beside = apply_homography(homographies[tie.a], tie.in_a + RIGHT) - in_a
    below = apply_homography(homographies[tie.a], tie.in_a + DOWN) - in_a
    return in_a, in_b, np.sqrt(np.abs(beside[:, 0] * below[:, 1] - beside[:, 1] * below[:, 0])) + 1e-9


def _cost(homographies: dict[int, Points], ties: list[Tie], scale_px: float) -> float:
    total = 0.0
    for tie in ties:
        in_a, in_b, scale = _meeting(homographies, tie)
        squared = ((in_a - in_b) ** 2).sum(axis=1) / (scale * scale_px) ** 2
        total += float(np.log1p(squared).sum())
    return total


def rmse_of(homographies: dict[int, Points], ties: list[Tie], scale_px: float) -> float:
    """Root mean square distance (eq. 6), in pixels of the pictures, over the ties that agree (within 3 scales)."""
    squared = []
    for tie in ties:
        in_a, in_b, scale = _meeting(homographies, tie)
        squared.append(((in_a - in_b) ** 2).sum(axis=1) / scale**2)
    together = np.concatenate(squared) if squared else np.zeros(1)
    agree = together[together <= (3 * scale_px) ** 2]
    return float(np.sqrt(agree.mean())) if agree.size else float("nan")


def _step(
    homographies: dict[int, Points], row: dict[int, int], ties: list[Tie], scale_px: float, damping: float
) -> Points:
    """Increments (F, 3, 3) in the mosaic. Its coordinates are scaled to about one for the sake of the numbers."""
    unit = 1000.0
    size = 8 * len(row)
    normal, pull = np.zeros((size, size)), np.zeros(size)
    for tie in ties:
        in_a, in_b, scale = _meeting(homographies, tie)
        left = (in_b - in_a) / unit
        weight = 1.0 / scale**2 / (1.0 + ((in_a - in_b) ** 2).sum(axis=1) / (scale * scale_px) ** 2)
        both = ((tie.a, 1.0, in_a), (tie.b, -1.0, in_b))
        sides = [(row[number], sign * _rows(at / unit)) for number, sign, at in both if number in row]
        for index, rows in sides:
            here = slice(8 * index, 8 * index + 8)
            pull[here] += np.einsum("nkj,nk,n->j", rows, left, weight)
            for other, columns in sides:
                normal[here, 8 * other : 8 * other + 8] += np.einsum("nki,nkj,n->ij", rows, columns, weight)
    normal[np.diag_indices(size)] *= 1 + damping
    entries = np.linalg.lstsq(normal, pull, rcond=None)[0].reshape(-1, 8)
    steps = np.concatenate((entries, np.zeros((len(entries), 1))), axis=1).reshape(-1, 3, 3)
    to_unit = np.diag([1 / unit, 1 / unit, 1.0])
    return np.linalg.inv(to_unit) @ steps @ to_unit


def _rows(at: Points) -> Points:
    """Derivatives (N, 2, 8) of a point (N, 2) by the entries of an increment of the identity."""
    x, y = at.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    across = np.stack((x, y, one, zero, zero, zero, -x * x, -x * y), axis=1)
    down = np.stack((zero, zero, zero, x, y, one, -x * y, -y * y), axis=1)
    return np.stack((across, down), axis=1)
