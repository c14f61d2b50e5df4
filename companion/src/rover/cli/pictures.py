"""Pictures for commands that take one picture a file: of a file with many it is said which."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rover.cli.output import say

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def read_picture(file: Path) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """As `rover.capture.picture.read_picture`."""
    from rover.capture.picture import read_picture_of_many

    picture, frames = read_picture_of_many(file)
    say_frame(file, frames)
    return picture


def say_frame(file: Path, frames: int) -> None:
    """One line on stderr where the file holds more than the picture that is used."""
    if frames > 1:
        say(f"{file}: frame 1 of {frames} is used")
