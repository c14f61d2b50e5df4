"""Planning anew whenever the map changes, at the cost of what has changed (section 3.5 of the paper)."""

from rover.planning.replanning.planner import Planner, Repair

__all__ = ["Planner", "Repair"]
