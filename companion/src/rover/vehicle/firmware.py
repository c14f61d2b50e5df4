"""Keys of the vehicle file that only the firmware needs: their parameters, there and back.

A key has a physical unit, a parameter the firmware's whole numbers. What has no key of its own stands in [firmware]
under the parameter's own name.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rover_protocol.parameters import BY_NAME

from rover.toml_table import Table
from rover.vehicle.model import Vehicle

Q15 = 32767.0


@dataclass(frozen=True)
class Key:
    """`table`.`name` times `factor` is the parameter's value."""

    table: str
    name: str
    parameter: str
    factor: float

    def bounds(self) -> tuple[float, float, float]:
        """Least, most and standard value, in the file's unit."""
        known = BY_NAME[self.parameter]
        return known.minimum / self.factor, known.maximum / self.factor, known.default / self.factor


KEYS = (
    Key("drive", "static_duty", "feed_static", Q15),
    Key("drive", "duty_per_m_s", "feed_velocity", Q15),
    Key("drive", "duty_per_m_s2", "feed_acceleration", Q15),
    Key("drive", "velocity_gain", "gain_velocity", Q15),
    Key("drive", "integral_gain", "gain_integral", Q15),
    Key("drive", "position_gain", "gain_position", 1.0),
    Key("battery", "nominal_v", "nominal_voltage", 1e3),
    Key("battery", "divider_scale", "battery_scale", 1e6),
)
WIRING = {
    "left_motor_inverted": 1,
    "right_motor_inverted": 2,
    "left_encoder_inverted": 4,
    "right_encoder_inverted": 8,
    "motors_swapped": 16,
    "encoders_swapped": 32,
}
SENSORS = ("left", "centre", "right")
# Which sensor the board's left, centre and right pins lead to; the place in this row is the parameter's value.
ORDERS = (
    ("left", "centre", "right"),
    ("left", "right", "centre"),
    ("centre", "left", "right"),
    ("centre", "right", "left"),
    ("right", "left", "centre"),
    ("right", "centre", "left"),
)
# What follows from keys above or from the rover's geometry, and the keys that it follows from.
OWNED = {
    **{key.parameter: f"[{key.table}] {key.name}" for key in KEYS},
    "track": "[wheels] track_m",
    "count_left": "[wheels] radius_m and counts_per_revolution",
    "count_right": "[wheels] radius_m and counts_per_revolution",
    "low_voltage": "[battery] low_v",
    "wiring": "[wiring]",
    "sonar_order": "[wiring] sonars",
}
WIRING_KEYS = (*WIRING, "sonars")
FREE = tuple(name for name in BY_NAME if name not in OWNED)


def keys_of(table: str) -> tuple[str, ...]:
    """Names of the firmware's keys in that table."""
    return tuple(key.name for key in KEYS if key.table == table)


def read_settings(top: Table) -> tuple[tuple[str, int], ...]:
    """Parameters that the file sets away from the firmware's defaults. Raises BadInput."""
    values: dict[str, int] = {}
    for key in KEYS:
        least, most, standard = key.bounds()
        values[key.parameter] = round(top.table(key.table).number(key.name, least, most, standard) * key.factor)
    wiring = top.table("wiring").only(*WIRING_KEYS)
    values["wiring"] = sum(bit for name, bit in WIRING.items() if wiring.flag(name, False))
    order = wiring.choices("sonars", SENSORS, SENSORS)
    if order not in ORDERS:
        raise wiring.error("sonars", "must name left, centre and right, each once, in the order of the board's pins")
    values["sonar_order"] = ORDERS.index(order)
    firmware = top.table("firmware")
    for name in firmware.names():
        if name in OWNED:
            raise firmware.error(name, f"follows from {OWNED[name]}; set it there")
    firmware.only(*FREE)
    for name in firmware.names():
        values[name] = firmware.integer(name, BY_NAME[name].minimum, BY_NAME[name].maximum)
        least, most = BY_NAME[name].start_minimum, BY_NAME[name].start_maximum
        if not least <= values[name] <= most:
            raise firmware.error(
                name, f"{values[name]} is a value for the bench: a rover sets off with {least} to {most}"
            )
    return tuple((name, value) for name, value in values.items() if value != BY_NAME[name].default)


def entries(name: str, value: int, vehicle: Vehicle) -> list[tuple[str, str, str]]:
    """(table, key, TOML literal) that make a file give this parameter this value."""
    for key in KEYS:
        if key.parameter == name:
            return [(key.table, key.name, shortest(value, key.factor))]
    match name:
        case "track":
            return [("wheels", "track_m", shortest(value, 1e6))]
        case "count_left" | "count_right":
            radius = value * 1e-12 * vehicle.counts_per_revolution / (2.0 * math.pi)
            side = "radius_m" if name == "count_left" else "right_radius_m"
            return [("wheels", side, f"{radius:.9g}")]
        case "low_voltage":
            return [("battery", "low_v", shortest(value, 1e3))]
        case "wiring":
            return [("wiring", key, "true" if value & bit else "false") for key, bit in WIRING.items()]
        case "sonar_order":
            return [("wiring", "sonars", "[" + ", ".join(f'"{sensor}"' for sensor in ORDERS[value]) + "]")]
        case _:
            return [("firmware", name, str(value))]


def shortest(value: int, factor: float) -> str:
    """The shortest decimal that gives the value again."""
    for digits in range(1, 18):
        text = f"{value / factor:.{digits}g}"
        if round(float(text) * factor) == value:
            break
    return text if any(letter in text for letter in ".en") else f"{text}.0"
