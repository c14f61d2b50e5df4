"""What an upright obstacle covers in the picture: itself, and the ground radially behind it that its image hides.

On the ground plane a thing of height h at distance d from the camera's foot is drawn out away from the camera up to
d·z/(z − h), z the height of the lens: its near edge lies where it stands, its far edge does not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rover.mapping.camera_view import CameraView

if TYPE_CHECKING:
    from rover.mapping.spot import ClassifiedSpot

# A detection counts as an obstacle from this probability on.
OBSTACLE = 0.4
# The classifier's blob is this much narrower than the thing, metres on either side.
GROWN = 0.02
# A mine's warmth, or a patch's, reaches farther than its blob, metres.
EXPLAINED = 0.04
# How far behind the spot's middle its image may reach, metres: an obstacle of 0.25 m at 0.9 m.
BEHIND = 0.45


@dataclass(frozen=True, eq=False)
class Cover:
    """Masks over the points of a CameraView.

    obstacle, core: where obstacles stand, and their middles; hidden: what they hide; explained: what a detection that
    is no obstacle accounts for.
    """

    obstacle: NDArray[np.bool_]
    core: NDArray[np.bool_]
    hidden: NDArray[np.bool_]
    explained: NDArray[np.bool_]


def obstacle_cover(view: CameraView, detections: Sequence[ClassifiedSpot]) -> Cover:
    """What the obstacles among the detections of one frame cover."""
    obstacle = np.zeros(len(view.points), bool)
    core, hidden, explained = obstacle.copy(), obstacle.copy(), obstacle.copy()
    for spot in detections:
        radius = max(0.5 * spot.extent, 0.05) + GROWN
        if spot.p.get("obstacle", 0.0) < OBSTACLE:
            dx, dy = view.points[:, 0] - spot.x, view.points[:, 1] - spot.y
            explained |= dx * dx + dy * dy < (radius + EXPLAINED) ** 2
            continue
        ahead, aside = spot.x - view.camera.x, spot.y - view.camera.y
        distance = math.hypot(ahead, aside)
        along = (view.offset[:, 0] * ahead + view.offset[:, 1] * aside) / distance - distance
        across = np.abs(view.offset[:, 1] * ahead - view.offset[:, 0] * aside) / distance
        near = across**2 + along**2
        obstacle |= near < radius**2
        core |= near < (0.5 * radius) ** 2
        hidden |= (across < radius) & (along > 0.0) & (along < BEHIND)
    return Cover(obstacle, core, hidden & ~obstacle, explained & ~obstacle)
