"""Rust and Python from one description of what goes over a wire."""
