"""Which mines of whole pictures are found, and how loudly: for the threshold that ships, and for the evaluation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture.detect import MAX_DETECTIONS, thin

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


def loudness(
    samples: PictureSamples, rows: NDArray[np.intp], score: NDArray[np.floating], records: Sequence[Record]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Of candidates `rows` with their scores: the best score of every mine (0: missed), those of all false alarms, and
    how many pictures there are. Pictures above MAX_HEIGHT do not count."""
    mines: list[float] = []
    false: list[float] = []
    pictures = np.unique(samples.picture[rows]).tolist()
    low = [picture for picture in pictures if records[picture].height <= MAX_HEIGHT]
    for picture in low:
        here = samples.picture[rows] == picture
        spots, scores = samples.spots[rows[here]], score[here]
        best = np.zeros(len(records[picture].boxes))
        for index in thin(spots, scores, MAX_DETECTIONS):
            box = hit(records[picture], spots[index].tolist())
            if box < 0:
                false.append(float(scores[index]))
            else:
                best[box] = max(best[box], scores[index])
        mines += best.tolist()
    return np.array(mines), np.array(false), len(low)


def threshold_for(pd: float, mines: NDArray[np.float64]) -> float:
    """The highest threshold that at least the share `pd` of the mines reach."""
    return float(np.sort(mines)[::-1][int(np.ceil(pd * len(mines))) - 1])
