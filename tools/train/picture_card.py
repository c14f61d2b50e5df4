"""The picture network's part of the model card."""

from __future__ import annotations

from rover.detection.picture_patch import LENGTH, NUMBERS, SIDE


def picture_section(pictures: int, notes: dict[str, str], sha256: str) -> str:
    """Markdown. pictures: how many were learned from. notes: of the calibration."""
    calibration = ", ".join(f"{name} {value}" for name, value in notes.items())
    return f"""Input: {LENGTH} numbers per candidate: a {SIDE}x{SIDE} thermal and a {SIDE}x{SIDE} occupancy patch and
{NUMBERS} numbers in units of the spot and of the picture (`rover.detection.picture_patch`). Output: calibrated
probabilities ({calibration}).

SHA-256: `{sha256}`

### Training

`python -m tools.train pictures --seed {notes["seed"]} --data DIR`: {pictures} real pictures of
Tenorio-Tamayo et al., Data in Brief 49:109443 (CC BY 4.0), 8-bit and not radiometric, as they lie on disk and altered
(turned, other contrast, smooth discs laid on the ground as casings). All zones are learned from; docs/detection.md tells what networks say of zones and
sessions that they never saw.

### Limits

Six real mines on one field. The pictures hold no obstacles: the class is there because every network has it, and is
hardly ever given. An indication is a reason to look closer, and the absence of one is no statement about the ground."""
