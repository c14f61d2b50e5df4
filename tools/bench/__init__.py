"""Measurements whose tables stand in docs/; every one is a command that anyone can run."""
