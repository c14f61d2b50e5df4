"""Pd and false alarms on whole pictures: by threshold, kind and flight, with intervals by flights drawn again."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from statistics import median

import numpy as np

from tools.evaluate.figures import table
from tools.evaluate.folds import FALSE_ALARMS, Outcome
from tools.train.picture.flights import flights, rate, told
from tools.train.picture.records import Record

THRESHOLDS = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9)
# Half the angle of view across and down (a 32 x 26 degree lens is an estimate), and the least height that is reliable.
ACROSS, DOWN, RELIABLE_HEIGHT = math.radians(16.0), math.radians(13.0), 3.0
KINDS = {"surface": "surface", "buried": "buried", "": "not told"}


def zones(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Folds of zones with pictures to judge: together they hold every picture once."""
    return [o for o in outcomes if o.name.startswith("zone") and o.pictures]


def area_m2(record: Record) -> float:
    """Ground that a picture from straight above shows."""
    return 4.0 * record.height**2 * math.tan(ACROSS) * math.tan(DOWN)


def detector_table(outcomes: Sequence[Outcome], records: Sequence[Record]) -> str:
    """By threshold on the score: Pd, false alarms a picture and per m²."""
    every, flight = zones(outcomes), flights(records)
    judged = np.array([p for o in every for p in o.judged], np.intp)
    area = np.array([area_m2(records[p]) for p in judged])
    reliable = np.array([records[p].height >= RELIABLE_HEIGHT for p in judged])
    boxes = np.array([len(records[p].boxes) for p in judged])
    rows = []
    for threshold in THRESHOLDS:
        found, false = np.zeros(len(records)), np.zeros(len(records))
        for o in every:
            loud = [a for a in o.alarms if a.score >= threshold]
            for picture, _ in {(a.picture, a.box) for a in loud if a.box >= 0}:
                found[picture] += 1
            np.add.at(false, np.array([a.picture for a in loud if a.box < 0], np.intp), 1)
        own = flight[judged]
        rows.append(
            [
                f"{threshold:g}",
                told(rate(found[judged], boxes, own)),
                told(rate(false[judged], np.ones(len(judged)), own), 3),
                told(rate(false[judged][reliable], area[reliable], own[reliable]), 3),
            ]
        )
    head = [f"Pd ({int(boxes.sum())} mines)", f"false alarms a picture ({len(judged)} pictures)"]
    return table(["threshold", *head, f"per m² ({reliable.sum()} pictures, {area[reliable].sum():.0f} m²)"], rows)


def _boxes(outcomes: Sequence[Outcome], records: Sequence[Record]) -> list[tuple[int, int, bool]]:
    """Picture, box and whether it was found, of every mine that was judged."""
    boxes = []
    for o in zones(outcomes):
        found = o.found_at(FALSE_ALARMS)
        boxes += [(p, box, (p, box) in found) for p in o.judged for box in range(len(records[p].boxes))]
    return boxes


def kinds_table(outcomes: Sequence[Outcome], records: Sequence[Record]) -> str:
    """Pd by kind and depth: over pictures, and as the mean over mines, a zone's own mine being one."""
    flight = flights(records)
    groups: dict[str, list[tuple[int, bool]]] = {}
    for picture, box, is_found in _boxes(outcomes, records):
        record = records[picture]
        depth = f", {record.depth_cm:g} cm" if record.boxes[box].kind == "buried" else ""
        groups.setdefault(KINDS[record.boxes[box].kind] + depth, []).append((picture, is_found))
    rows = []
    for name, some in sorted(groups.items()):
        pictures, hits = (np.array(part) for part in zip(*some, strict=True))
        own, zone = flight[pictures], np.array([records[p].zone for p in pictures.tolist()])
        of_mine = [float(hits[zone == each].mean()) for each in np.unique(zone)]
        share = told(rate(hits.astype(float), np.ones(len(hits)), own)) if len(set(own)) > 1 else f"{hits.mean():.2f}"
        rows.append([name, str(len(of_mine)), str(len(set(own))), str(len(hits)), share, f"{np.mean(of_mine):.2f}"])
    return table(["what", "zones", "flights", "times in a picture", "Pd", "mean over zones"], rows)


def by_flight_table(outcomes: Sequence[Outcome], records: Sequence[Record]) -> str:
    """Pd and false alarms of every flight."""
    found, false = Counter[str](), Counter[str]()
    mines, pictures = Counter[str](), Counter[str]()
    warmth: dict[str, list[float]] = {}

    def name(picture: int) -> str:
        return f"zone {records[picture].zone}, session {records[picture].session}"

    for picture, _, is_found in _boxes(outcomes, records):
        mines[name(picture)] += 1
        found[name(picture)] += is_found
    for o in zones(outcomes):
        least = o.threshold_at(FALSE_ALARMS)
        false.update(name(a.picture) for a in o.alarms if a.box < 0 and a.score >= least)
        for picture in o.judged:
            pictures[name(picture)] += 1
            warmth.setdefault(name(picture), []).append(records[picture].centre_temp_c)
    rows = [
        [
            each,
            f"{median(warmth[each]):.0f} °C",
            f"{found[each]} of {mines[each]}",
            f"{false[each] / pictures[each]:.2f}",
        ]
        for each in sorted(pictures)
    ]
    return table(["flight", "at the middle", "found", "false alarms a picture"], rows)
