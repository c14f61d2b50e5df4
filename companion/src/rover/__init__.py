"""The companion computer's side of the rover: it sees, maps, detects, plans and streams motion."""

__version__ = "0.1.0"
