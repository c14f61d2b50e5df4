"""Pinhole cameras: the model, its file, its pose."""
