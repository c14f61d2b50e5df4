"""The picture network's part of the model card."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
from rover.detection.picture.circles import NUMBERS
from rover.detection.picture.patch import CELLS, DIRECTIONS, LENGTH, SHOWN_SIDE, SIDE

from tools.evaluate.figures import binomial, poisson

if TYPE_CHECKING:
    from tools.train.picture.calibration import Calibration


def picture_section(pictures: int, notes: dict[str, str], known: Calibration, sha256: str) -> str:
    """Markdown. pictures: how many were learned from. notes: what the file says of itself."""
    calibration = ", ".join(f"{name} {value}" for name, value in notes.items())
    return f"""Input: {LENGTH} numbers per candidate (`rover.detection.picture.patch`): a {SIDE}x{SIDE} thermal patch,
an {SHOWN_SIDE}x{SHOWN_SIDE} occupancy patch, an {SHOWN_SIDE}x{SHOWN_SIDE} wider patch, gradients in {DIRECTIONS}
directions in {CELLS}x{CELLS} cells of both, and {NUMBERS} numbers from circles in units of the spot and of the
picture, among them how the spot stands among all spots of its picture. Output: probabilities, calibrated as means
over the candidate's four mirror images, which is how `rover detect` asks
({calibration}).

SHA-256: `{sha256}`

### Training

`.venv/bin/python -m tools.train pictures --seed {notes["seed"]} --data DIR`:
{pictures} real pictures of Tenorio-Tamayo et al.,
Data in Brief 49:109443 (CC BY 4.0), 8-bit and not radiometric, as they lie on disk and altered (turned, other contrast,
smooth discs laid on the ground as casings, which count little), with OpenCV {cv2.__version__}. A first network shows
which ground is taken for mines; that is learned from too. A second one and gradient boosting say what they make of all
of it; the network that ships learns half from the labels, half from the mean of what the two say, and of some
candidates without a label from that alone. All zones are learned from; docs/results/detection.md tells what
networks say of zones and sessions that they never saw.

### Calibration and threshold

From three networks that never saw the zones that they judge. Expected calibration error of candidates where a mine has
at least 0.1: {known.error:.3f}. The file's threshold, {known.threshold:g}, is the highest that nine in ten mines
of such zones reach, in pictures up to 4 m: probability of detection {binomial(known.found, known.mines)}, false alarms
a picture {poisson(known.false, known.pictures)}. `rover detect` leaves out what is below it unless `--threshold` says
otherwise.

### Limits

Six real mines on one field. The pictures hold no obstacles: the class is there because every network has it, and is
hardly ever given. An indication is a reason to look closer, and the absence of one is no statement about the ground."""
