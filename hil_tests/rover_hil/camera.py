"""Frames of the simulated field: the rover stands at its launch and turns on the spot, no firmware, no companion.

To try what follows a camera without one. A mission on a simulated rig gets its frames through its rig instead.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rover.capture.frame import Frame
from rover.capture.location import Location
from rover.errors import BadInput
from rover.mission.config import load
from rover.vision.camera.file import load_camera

from rover_hil.ground import build
from rover_hil.plant_config import build_plant

# Steps of one millisecond between two looks for a frame.
STEPS_PER_READ = 20


class SimulatorSource:
    """`simulator:MISSION[?seed=1][&seconds=10][&duty=0.2]`: MISSION as for `rover run`; the same seed, the same frames.

    Raises BadInput for a bad mission or option.
    """

    def __init__(self, location: str) -> None:
        parsed = Location.parse(location, ("seed", "seconds", "duty"))
        self.mission = parsed.place or "demo"
        self.seed = round(parsed.number("seed", 1.0))
        self.seconds = parsed.number("seconds", 10.0)
        self.duty = parsed.number("duty", 0.2)
        if self.duty > 1.0:
            raise BadInput(f"{location}: duty={self.duty:g}: at most 1 is expected")

    def __iter__(self) -> Iterator[Frame]:
        mission = load(self.mission)
        camera = load_camera(mission.rover.camera)
        plant = build_plant(mission, build(mission, self.seed), camera, self.seed)
        while plant.now_us < self.seconds * 1e6:
            for _ in range(STEPS_PER_READ):
                plant.step(-self.duty, self.duty, True)
            for sequence, exposure_us, _, ffc, pixels in plant.take_frames():
                counts = np.frombuffer(pixels, "<u2").reshape(camera.height, camera.width).astype(np.uint16)
                yield Frame(counts, exposure_us * 1e-6, sequence, ffc, camera=f"simulated {camera.name}")
