"""How well a pixel's place on the ground is known by the shipped cameras: `python -m tools.calibrate.ground_sigma`."""

from __future__ import annotations

import math

import numpy as np
from rover.vision.calibration.mount import MOUNT
from rover.vision.calibration.uncertainty import UncertainCamera
from rover.vision.camera.file import load_camera

SIGMA_PX = 0.5
SIGMA_POSITION = 0.005
SIGMA_ANGLE = math.radians(0.3)
REACHES = (0.3, 0.5, 0.75, 1.0)


def main() -> None:
    """A row for each camera and distance: standard deviation along and across, pixel alone and with the mount."""
    spread = np.diag(np.square([SIGMA_POSITION] * 3 + [SIGMA_ANGLE] * 3))
    print("| camera | ahead, m | pixel alone: along, across, mm | with the mount: along, across, mm |")
    print("|---|--:|--:|--:|")
    for name in ("lepton-160", "e6390-320"):
        camera = load_camera(name)
        for reach in REACHES:
            pixel = camera.ground_to_pixel(np.array([[reach, 0.0]]))
            if not camera.inside(pixel)[0]:
                continue
            cells = []
            for known in (UncertainCamera(camera, (), np.zeros((0, 0))), UncertainCamera(camera, MOUNT, spread)):
                _, covariance = known.pixel_to_ground(pixel, SIGMA_PX)
                cells.append(", ".join(f"{1000 * math.sqrt(covariance[0, i, i]):.1f}" for i in (0, 1)))
            print(f"| {name} | {reach:g} | {cells[0]} | {cells[1]} |")


if __name__ == "__main__":
    main()
