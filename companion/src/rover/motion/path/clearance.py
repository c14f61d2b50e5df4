"""Measured clearance: how far a disc may be moved before it touches anything, and whether it may be swept along.

Everything errs to the safe side: what can't be shown to be clear counts as blocked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.planning.fields import Field, GridField

Array = NDArray[np.float64]

# Chords are halved so often before one that is still in doubt counts as blocked: 1/64 of its length.
MAX_HALVINGS = 6


@dataclass(frozen=True)
class ClearanceMap:
    """What the motion asks of a map.

    `margin`: for points (N, 2) in metres a lower bound (N,) of how far a disc of the robot's radius there may be moved
    in any direction before it touches anything; negative where it touches. `passes`: exact check of one straight sweep
    of that disc grown by a slack, for where the bound leaves a doubt; None when there is none.
    """

    margin: Callable[[Array], Array]
    passes: Callable[[tuple[float, float], tuple[float, float], float], bool] | None = None

    @classmethod
    def of(cls, field: Field, radius: float) -> ClearanceMap:
        """Of a planner's map, for a disc of `radius` metres."""
        # A grid's clearance is interpolated between the cells' centres, by less than half a cell too much.
        error = 0.5 * field.resolution if isinstance(field, GridField) else 0.0
        return cls(
            lambda points: field.clearance(points) - (radius + error),
            lambda a, b, slack: field.segment_clear(a, b, radius + slack),
        )

    def swept(self, a: Array, b: Array, slack: Array) -> NDArray[np.bool_]:
        """(N,) True where the disc, grown by `slack` (N,), may be swept from `a` to `b`, (N, 2) each.

        The margin is 1-Lipschitz: a chord is clear when its middle has a margin of half its length. Chords in doubt
        are halved.
        """
        clear = np.ones(len(a), dtype=bool)
        index = np.arange(len(a))
        for _ in range(MAX_HALVINGS):
            middle = (a + b) / 2.0
            spare = self.margin(middle) - slack
            half = np.hypot(*(b - a).T) / 2.0
            doubt = ~(spare >= half)
            if not doubt.any():
                return clear
            a, b, middle, slack, index = a[doubt], b[doubt], middle[doubt], slack[doubt], index[doubt]
            if self.passes is not None:
                for i, start, end, grown in zip(index.tolist(), a.tolist(), b.tolist(), slack.tolist(), strict=True):
                    clear[i] &= self.passes((start[0], start[1]), (end[0], end[1]), grown)
                return clear
            # Blocked for certain: no need to look closer.
            blocked = ~(spare[doubt] >= 0.0)
            clear[index[blocked]] = False
            keep = clear[index]
            a, b, middle, slack, index = a[keep], b[keep], middle[keep], slack[keep], index[keep]
            a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
            slack, index = np.concatenate([slack, slack]), np.concatenate([index, index])
        clear[index] = False
        return clear
