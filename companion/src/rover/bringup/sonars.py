"""From what every sensor says of a box before one of them to what is crossed, dead, or hears its neighbour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from rover.link.telemetry import SonarRange
from rover.vehicle.firmware import ORDERS, SENSORS

# A range counts as that of the box when it is this near to it: metres, and a share of it.
NEAR_M, NEAR_SHARE = 0.03, 0.12
# Further off by scale than any air is: the echo's pulse is cut, or the box stood elsewhere.
SCALE = 0.05


@dataclass(frozen=True)
class Boxed:
    """A box stood before `sensor` at `distance` (m); what the board's left, centre and right pins said."""

    sensor: int
    distance: float
    said: Sequence[Sequence[SonarRange]]


@dataclass(frozen=True)
class Found:
    """order: value of the firmware's parameter, None when it cannot be told; faults: each a sentence."""

    order: int | None
    faults: tuple[str, ...]
    told: tuple[str, ...]
    scale: float | None


def judge(boxes: Sequence[Boxed]) -> Found:
    """With the pins taken as they are (no order put right in software)."""
    faults: list[str] = []
    for pins, name in enumerate(SENSORS):
        statuses = {event.status for boxed in boxes for event in boxed.said[pins]}
        if not statuses:
            faults.append(f"the {name} pins say nothing: is the sensor fitted, and its trigger connected?")
        elif statuses == {"Dead"}:
            faults.append(f"the sensor on the {name} pins is dead: supply, trigger, or an echo that stays low or high")
    pins_of: dict[int, set[int]] = {}
    ratios = []
    for boxed in boxes:
        seen = [pins for pins in range(len(SENSORS)) if _sees(boxed, pins)]
        ratios += [_median(boxed, pins) / boxed.distance for pins in seen]
        pins_of.setdefault(boxed.sensor, set()).update(seen)
        if len(seen) > 1:
            names = " and ".join(SENSORS[pins] for pins in seen)
            faults.append(f"a box before the {SENSORS[boxed.sensor]} sensor is seen on the {names} pins: cross-talk")
        elif not seen and not any(event.status == "Dead" for pins in range(3) for event in boxed.said[pins]):
            faults.append(
                f"nobody sees the box at {boxed.distance:g} m before the {SENSORS[boxed.sensor]} sensor: its echo is "
                "too weak or cut (a divider of 5 V to 3.3 V), or it looks elsewhere"
            )
    order = None
    if all(len(pins_of.get(sensor, ())) == 1 for sensor in range(len(SENSORS))):
        sensor_of = {next(iter(pins)): sensor for sensor, pins in pins_of.items()}
        if len(sensor_of) == len(SENSORS):
            order = ORDERS.index(tuple(SENSORS[sensor_of[pins]] for pins in range(len(SENSORS))))
    scale = median(ratios) if ratios else None
    if scale is not None and abs(scale - 1.0) > SCALE:
        faults.append(f"ranges are {100.0 * (scale - 1.0):+.0f} % off: sound_speed, or a box that stood elsewhere")
    told = "the sensors are on their pins" if order == 0 else "the sensors are on each other's pins"
    return Found(order, tuple(dict.fromkeys(faults)), (told,) if order is not None else (), scale)


def _median(boxed: Boxed, pins: int) -> float:
    told = [event.range_m for event in boxed.said[pins] if event.range_m is not None]
    return median(told) if told else 0.0


def _sees(boxed: Boxed, pins: int) -> bool:
    return abs(_median(boxed, pins) - boxed.distance) <= NEAR_M + NEAR_SHARE * boxed.distance
