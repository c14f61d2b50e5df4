"""Makes the pictures of this folder anew: frames of a simulated drive, and a radiometric JPEG of one of them.

    python docs/examples/make_pictures.py [FOLDER]

All of them are synthetic. The same seed gives the same bytes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import write_picture
from rover.mission.config import load
from rover.vision.camera.file import load_camera
from rover_hil.ground import build
from rover_hil.plant_config import build_plant

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))
from companion.tests.capture.flir_sample import counts_of, flir_file, jpeg_with  # noqa: E402

SEED = 3
DUTY = 0.3
FRAMES, EVERY = 6, 4
"""How many frames are kept, and one of how many: about half a second apart."""


def drive() -> list[NDArray[np.uint16]]:
    """Frames (120, 160), kelvin × 100, of a rover that drives straight ahead over the field of mission.toml."""
    mission = load(HERE / "mission.toml")
    camera = load_camera(mission.rover.camera)
    plant = build_plant(mission, build(mission, SEED), camera, SEED)
    taken: list[NDArray[np.uint16]] = []
    while len(taken) < FRAMES * EVERY:
        plant.step(DUTY, DUTY, True)
        for _, _, _, shutter_closed, pixels in plant.take_frames():
            if not shutter_closed:
                taken.append(np.frombuffer(pixels, "<u2").reshape(camera.height, camera.width).astype(np.uint16))
    return taken[EVERY - 1 :: EVERY]


def main(folder: Path = HERE) -> None:
    """Writes frames/*.png and thermal.jpg into the folder."""
    frames = drive()
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    for number, counts in enumerate(frames):
        write_picture(folder / "frames" / f"{number:02}.png", counts)
    raw = counts_of(frames[0].astype(np.float64) / 100.0)
    (folder / "thermal.jpg").write_bytes(jpeg_with(flir_file(raw, "png", "<")))


if __name__ == "__main__":
    main(*(Path(name) for name in sys.argv[1:2]))
