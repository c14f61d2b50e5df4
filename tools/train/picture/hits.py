"""Which mines of whole pictures are found, and how loudly: for the threshold that ships, and for the evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture.detect import MAX_DETECTIONS, thin

from tools.train.picture.flights import rate
from tools.train.picture.records import Record
from tools.train.picture.samples import PictureSamples

# Whole pictures count up to this height, metres.
MAX_HEIGHT = 4.0
# A detection counts within the box and 10 cm around it. Heights are unreliable, so 10 cm are told by the boxes: buried
# mines are about 27 cm wide in them, surface mines 15 cm; the lesser halo of the two serves for both.
HALO = 0.37


def hit(record: Record, spot: Sequence[float], around: float = HALO) -> int:
    """The box whose halo holds the middle of a spot, -1 for none."""
    for index, box in enumerate(record.boxes):
        halo = around * box.side
        if abs(spot[0] - box.x) < 0.5 * box.width + halo and abs(spot[1] - box.y) < 0.5 * box.height + halo:
            return index
    return -1


@dataclass(frozen=True, eq=False)
class Loudness:
    """Best score of every mine (0: missed) and the scores of all false alarms, each with the number of its picture;
    pictures: all that were judged. Pictures above MAX_HEIGHT are not among them."""

    mines: NDArray[np.float64]
    mine_picture: NDArray[np.intp]
    false: NDArray[np.float64]
    false_picture: NDArray[np.intp]
    pictures: NDArray[np.intp]

    def at(self, threshold: float, flight: NDArray[np.intp]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Probability of detection and false alarms a picture, with intervals for as many other flights; flight (P,)
        of every picture."""
        found = (self.mines >= threshold).astype(float)
        alarms = np.bincount(self.false_picture[self.false >= threshold], minlength=len(flight))[self.pictures]
        pd = rate(found, np.ones_like(found), flight[self.mine_picture], True)
        return (
            tuple(min(share, 1.0) for share in pd),
            rate(alarms.astype(float), np.ones(len(alarms)), flight[self.pictures], True),
        )

    def threshold_for(self, alarms: float) -> float:
        """The least threshold that lets no more than so many false alarms a picture through."""
        allowed = int(alarms * len(self.pictures))
        louder = np.sort(self.false)[::-1]
        return float(np.nextafter(louder[allowed], np.inf)) if allowed < len(louder) else 0.0


def loudness(
    samples: PictureSamples, rows: NDArray[np.intp], score: NDArray[np.floating], records: Sequence[Record]
) -> Loudness:
    """Of candidates `rows` with their scores."""
    mines: list[tuple[float, int]] = []
    false: list[tuple[float, int]] = []
    low = [p for p in np.unique(samples.picture[rows]).tolist() if records[p].height <= MAX_HEIGHT]
    for picture in low:
        here = samples.picture[rows] == picture
        spots, scores = samples.spots[rows[here]], score[here]
        best = np.zeros(len(records[picture].boxes))
        for index in thin(spots, scores, MAX_DETECTIONS):
            box = hit(records[picture], spots[index].tolist())
            if box < 0:
                false.append((float(scores[index]), picture))
            else:
                best[box] = max(best[box], scores[index])
        mines += [(float(value), picture) for value in best]
    parts = [np.array(each, float).reshape(-1, 2) for each in (mines, false)]
    (of_mines, mine_picture), (of_false, false_picture) = (part.T for part in parts)
    return Loudness(
        of_mines, mine_picture.astype(np.intp), of_false, false_picture.astype(np.intp), np.array(low, np.intp)
    )
