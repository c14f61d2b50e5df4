"""Inner loops of the rover's planner; see src/lib.rs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

class NativeField:
    @staticmethod
    def circles(width: float, height: float, obstacles: NDArray[np.float64]) -> NativeField: ...
    @staticmethod
    def grid(
        blocked: NDArray[np.uint8], resolution: float, origin_x: float, origin_y: float
    ) -> NativeField: ...
    @property
    def bounds(self) -> tuple[float, float, float, float]: ...
    def clearance(self, at: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def segment_clear(self, a: tuple[float, float], b: tuple[float, float], radius: float) -> bool: ...
    def plan(
        self,
        start: tuple[float, float],
        goals: NDArray[np.float64],
        algorithm: str,
        seed: int,
        settings: dict[str, Any],
    ) -> dict[str, Any]: ...
    def multi_goal_tree(
        self,
        start: tuple[float, float],
        goals: NDArray[np.float64],
        radius: float,
        seed: int,
        iterations: int,
        step: float,
        bias: float,
    ) -> tuple[NDArray[np.float64], list[int], list[int], int]: ...

class NativePlanner:
    def __init__(self, seed: int) -> None: ...
    def prepare(self, field: NativeField, radius: float) -> tuple[int, int]: ...
    def plan(
        self,
        field: NativeField,
        start: tuple[float, float],
        goals: NDArray[np.float64],
        settings: dict[str, Any],
    ) -> dict[str, Any]: ...

class Views:
    def __init__(
        self, footprint: NDArray[np.float64], headings: NDArray[np.float64], resolution: float
    ) -> None: ...
    def open_gains(self, unseen: NDArray[np.uint8], positions: NDArray[np.int32]) -> NDArray[np.uint32]: ...
    def gains(
        self, unseen: NDArray[np.uint8], blocked: NDArray[np.uint8], views: NDArray[np.int32]
    ) -> NDArray[np.uint32]: ...

def clearance_map(blocked: NDArray[np.uint8], resolution: float) -> NDArray[np.float32]: ...
def distance_field(
    blocked: NDArray[np.uint8], start: tuple[int, int], resolution: float
) -> NDArray[np.float32]: ...
