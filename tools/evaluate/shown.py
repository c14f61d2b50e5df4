"""The worst misses and false alarms as pictures. Those of real pictures go to a folder that is not committed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.evaluate.folds import Alarm, Outcome
from tools.train.picture.records import Record

TILE, PER_ROW, MOST = 256, 6, 18
RED, GREEN = (0, 0, 255), (0, 255, 0)


def write_worst(outcomes: Sequence[Outcome], records: Sequence[Record], folder: Path) -> list[Path]:
    """`misses.png` and `false_alarms.png`: boxes red, detections green with their score."""
    folder.mkdir(parents=True, exist_ok=True)
    alarms = [a for o in outcomes if o.name.startswith("zone") for a in o.alarms]
    pictures = sorted({a.picture for a in alarms})
    best = {i: max((a.score for a in alarms if a.picture == i and a.box >= 0), default=0.0) for i in pictures}
    loud = {i: max((a.score for a in alarms if a.picture == i and a.box < 0), default=0.0) for i in pictures}
    files = []
    for name, order in (
        ("misses", sorted(pictures, key=lambda i: best[i])),
        ("false_alarms", sorted(pictures, key=lambda i: -loud[i])),
    ):
        tiles = [_tile(records[i], [a for a in alarms if a.picture == i][:4]) for i in order[:MOST]]
        tiles += [np.zeros((TILE, TILE, 3), np.uint8)] * (-len(tiles) % PER_ROW)
        rows = [np.hstack(tiles[i : i + PER_ROW]) for i in range(0, len(tiles), PER_ROW)]
        files.append(folder / f"{name}.png")
        cv2.imwrite(str(files[-1]), np.vstack(rows))
    return files


def _tile(record: Record, alarms: Sequence[Alarm]) -> NDArray[np.uint8]:
    picture = cv2.cvtColor(record.grey, cv2.COLOR_GRAY2BGR)
    for b in record.boxes:
        low, high = (b.x - b.width / 2, b.y - b.height / 2), (b.x + b.width / 2, b.y + b.height / 2)
        cv2.rectangle(picture, (round(low[0]), round(low[1])), (round(high[0]), round(high[1])), RED, 3)
    for alarm in alarms:
        x, y, extent = alarm.spot
        cv2.circle(picture, (round(x), round(y)), round(extent / 2), GREEN, 2)
        cv2.putText(picture, f"{alarm.score:.2f}", (round(x), round(y)), cv2.FONT_HERSHEY_SIMPLEX, 1.0, GREEN, 2)
    cv2.putText(picture, record.name, (5, 30), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (255, 255, 0), 2)
    return np.asarray(cv2.resize(picture, (TILE, TILE), interpolation=cv2.INTER_AREA), np.uint8)
