"""Recorded streams fed back: into a rig's firmware, and into the companion's estimators and mission."""
