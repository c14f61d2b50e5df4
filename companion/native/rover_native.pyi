"""Inner loops of the rover's planner, in Rust; see src/lib.rs.

Lengths in metres, times in milliseconds, angles in radians. Arrays are C-contiguous or copied. Values that make no
sense raise ValueError with one line.
"""

from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

class Settings(TypedDict):
    """How to plan. Every key is needed."""

    robot_radius: float
    """At least 0."""
    iterations: int | None
    """Tree extensions and shortcut attempts by which the answer is improved; None: see budget_ms."""
    budget_ms: float | None
    """Milliseconds by the clock until which the answer is improved; neither: the first solution, simplified."""
    any_order: bool
    """The planner chooses the order of the goals."""
    start_recovery_m: float
    """How far a start that is too near an obstacle may be moved away from it."""
    corner_cost_m: float
    """Length that one corner less is worth."""
    step_m: float | None
    """Δt of eq. 13; None: a tenth of the map's diagonal."""
    goal_bias: float | None
    """Share of the samples that are a goal, 0 to 1; None: the algorithm's own."""

class Outcome(TypedDict):
    """What planning found."""

    order: list[int]
    """Goals in order of visit, by their number in the request."""
    path: NDArray[np.float64]
    """(N, 2), from the start through all goals in `order`."""
    goal_indices: list[int]
    """Row of `path` at which each goal of `order` is met."""
    unreachable: list[int]
    """Goals without a path."""
    iterations: int
    """Of all stages: tree extensions, shortcut attempts, simplified paths, expanded cells."""
    nodes: int
    """Nodes of all trees, and labelled cells of lattices."""
    stages: list[tuple[str, float, int]]
    """What ran: name, milliseconds, iterations."""
    time_ms: float
    """By the clock."""
    first_solution_ms: float | None
    """The same until the first valid tour; None when no goal can be reached."""
    start_blocked: bool
    """The start is too near an obstacle to be left."""

class RepairedOutcome(Outcome):
    """The same, and what became of the plan before."""

    kept: int
    """Nodes of the tree, or points of the legs, that are still in use."""
    pruned: int
    """Those that were dropped."""
    rewired: int
    """Nodes that found another parent, or gaps in legs that were bridged."""

class NativeField:
    """A map: circles in a rectangle, or blocked cells. Bounds count as walls."""

    @staticmethod
    def circles(width: float, height: float, obstacles: NDArray[np.float64]) -> NativeField:
        """The rectangle [0, width] × [0, height] with obstacles (N, 3) of x, y, radius."""

    @staticmethod
    def grid(blocked: NDArray[np.uint8], resolution: float, origin_x: float, origin_y: float) -> NativeField:
        """Cells (rows, columns) of `resolution` metres, not 0 is blocked; row 0 lies at `origin_y`. Copied."""

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, y_min, x_max, y_max)."""

    def clearance(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance (N,) from each of the (N, 2) points to the nearest obstacle or wall; not positive inside one."""

    def segment_clear(self, a: tuple[float, float], b: tuple[float, float], radius: float) -> bool:
        """True when a disc of `radius` swept from a to b stays inside the bounds and touches nothing."""

    def plan(
        self, start: tuple[float, float], goals: NDArray[np.float64], algorithm: str, seed: int, settings: Settings
    ) -> Outcome:
        """A path from `start` through goals (N, 2). Other threads run meanwhile."""

    def multi_goal_tree(
        self,
        start: tuple[float, float],
        goals: NDArray[np.float64],
        radius: float,
        seed: int,
        iterations: int,
        step: float,
        bias: float,
    ) -> tuple[NDArray[np.float64], list[int], list[int], int]:
        """Figure 3's tree alone: nodes (N, 2), parents (-1: the root), the node at each goal or -1, iterations."""

class NativePlanner:
    """The multi-goal planner with a memory: what is still valid on the next map is kept."""

    def __init__(self, seed: int) -> None: ...
    def prepare(self, field: NativeField, radius: float) -> tuple[int, int]:
        """Builds a roadmap of `field` for plans on maps to come; its numbers of nodes and edges."""

    def plan(
        self, field: NativeField, start: tuple[float, float], goals: NDArray[np.float64], settings: Settings
    ) -> RepairedOutcome:
        """As `NativeField.plan` with "multi-goal", starting from the plan before."""

class Views:
    """A camera's footprint at a set of headings, prepared once for many questions."""

    def __init__(self, footprint: NDArray[np.float64], headings: NDArray[np.float64], resolution: float) -> None:
        """`footprint`: convex polygon (M, 2) in base_link; `headings`: (K,); `resolution`: metres per cell."""

    def open_gains(self, unseen: NDArray[np.uint8], positions: NDArray[np.int32]) -> NDArray[np.uint32]:
        """Unseen cells (N, K) in view from positions (N, 2) of column and row, nothing hidden: an upper bound."""

    def gains(
        self, unseen: NDArray[np.uint8], blocked: NDArray[np.uint8], views: NDArray[np.int32]
    ) -> NDArray[np.uint32]:
        """Unseen cells (N,) that no blocked cell hides, for views (N, 3) of column, row and heading's number."""

def clearance_map(blocked: NDArray[np.uint8], resolution: float) -> NDArray[np.float32]:
    """Distance (rows, columns) from each cell's centre to the nearest blocked square; 1e9 when nothing is blocked."""

def distance_field(blocked: NDArray[np.uint8], start: tuple[int, int], resolution: float) -> NDArray[np.float32]:
    """Travel distance (rows, columns) over free cells from `start` = (column, row); infinite where there is no path."""

def bend_speeds(
    length: NDArray[np.float64],
    curvature: NDArray[np.float64],
    slope: NDArray[np.float64],
    thirds: NDArray[np.float64],
    most: NDArray[np.float64],
    share: NDArray[np.float64],
    travel: tuple[float, float],
    heading: tuple[float, float],
    former: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds and accelerations (N + 1) at the nodes of N curves.

    `former`: most, share and speed at the nodes of the same curves, to begin with.
    """

AveragedAxis = tuple[
    NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]
]
Places = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

def averaged(axis: AveragedAxis, places: Places) -> NDArray[np.float64]:
    """(K, 4): the average of polylines and its slope at K places; see rover.motion.path.average."""

def averaged_bending(axis: AveragedAxis, places: Places) -> NDArray[np.float64]:
    """(4, K): how far it is from the polylines, its curvature, and the first two derivatives of that."""

def heading_splines(
    length: NDArray[np.float64], angle: NDArray[np.float64], ends: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(N, 4): curvature at both ends of N curves and its slope at both. `ends`: curves up to the end of each run."""

def curve_points(curves: NDArray[np.float64], chords: int) -> NDArray[np.float64]:
    """((chords + 1) N, 2): the ends of equal parts of N curves (N, 9)."""

class RowMark:
    """A place in a row of segments."""

    @property
    def segments(self) -> int:
        """How many come before."""

class SegmentRow:
    """Segments in the making: whole numbers, and the exact state and pose at their end."""

    def __init__(self, x: float, y: float, heading: float) -> None: ...
    @property
    def state(self) -> tuple[float, float, float, float, float, float, float]:
        """x, y, heading, speed, acceleration, turn rate, turn acceleration at the end."""

    def __len__(self) -> int: ...
    def add(self, duration_us: int, jerk_travel: int, jerk_heading: int) -> None:
        """One segment: µs, and millionths of the SI unit."""

    def follow(self, curves: NDArray[np.float64], travel: tuple[float, float], heading: tuple[float, float]) -> None:
        """Three segments for each of N curves (N, 10)."""

    def rest(self) -> None:
        """What was added last ends at rest; what comes next begins a run."""

    def mark(self) -> RowMark:
        """To come back to."""

    def reset(self, mark: RowMark) -> None:
        """Forgets what was added after the mark."""

    def shares(self, mark: RowMark, allowed: tuple[float, ...]) -> NDArray[np.float64]:
        """(N, 2) of the segments behind a mark: largest shares of what is allowed."""

    def fields(self, first: int) -> NDArray[np.int64]:
        """(N, 5) from segment number `first` on."""

def segments_way(
    fields: NDArray[np.int64], pose: tuple[float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], list[float]]:
    """Poses (N + 1, 3), points (M, 2), segment of each (M,), bulges (M - 1,), and the largest magnitudes."""

def way_beside(
    way: tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]],
    line: tuple[NDArray[np.float64], NDArray[np.float64]],
    starts: NDArray[np.int64],
    legs: NDArray[np.int64],
) -> NDArray[np.float64]:
    """(M - 1,) metres, no less than the distance from the way between M points to the legs of its piece."""
