"""Planning: where to stand, where to look from, and how to get there (sections 3.4 and 3.5 of the paper)."""

from rover.planning.fields import CircleField, Field, GridField, load_field
from rover.planning.inspection import inspection_poses
from rover.planning.planner import ALGORITHMS, plan
from rover.planning.replanning import Planner, Repair
from rover.planning.result import PlanResult
from rover.planning.viewpoints import Viewpoint, ViewpointSettings, distance_field, viewpoints

__all__ = [
    "ALGORITHMS",
    "CircleField",
    "Field",
    "GridField",
    "PlanResult",
    "Planner",
    "Repair",
    "Viewpoint",
    "ViewpointSettings",
    "distance_field",
    "inspection_poses",
    "load_field",
    "plan",
    "viewpoints",
]
