"""The rate of a serial line, where nothing else is asked for."""

from __future__ import annotations

# Bits per second; `firmware/pico/src/pins.rs` has the board's own, and a test compares them.
DEFAULT_BAUD = 230_400
