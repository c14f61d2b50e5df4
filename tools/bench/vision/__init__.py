"""Localization, its time, registration and preprocessing, measured on simulated drives and on real pictures.

python -m tools.bench vision                       # every table; the real pictures through ROVER_DATA
python -m tools.bench vision --only drives --seeds 8
"""

from tools.bench.vision.bench import main

__all__ = ["main"]
