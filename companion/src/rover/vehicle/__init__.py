"""The vehicle file: one truth about a rover for companion, firmware and simulated plant."""

from rover.vehicle.file import load_vehicle
from rover.vehicle.model import SONARS, STANDARD, Limits, Pack, SonarMount, Vehicle

__all__ = ["SONARS", "STANDARD", "Limits", "Pack", "SonarMount", "Vehicle", "load_vehicle"]
