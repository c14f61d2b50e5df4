"""Checks of calibrations against what is published, and of how well they do on known cameras."""
