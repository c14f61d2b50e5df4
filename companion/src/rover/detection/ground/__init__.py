"""Frames laid on the ground, in kelvin and metres: candidates and their descriptions."""
