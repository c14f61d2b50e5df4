"""What a firmware tells, gathered into moments: the last of every measurement at regular times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from rover.link.self_test import SENSORS
from rover.link.session import STEP_S, Link
from rover.link.telemetry import (
    Battery,
    FirmwareState,
    LinkQuality,
    MotorDuty,
    SonarRange,
    Telemetry,
    Velocity,
    WheelMotion,
)

# Period of the messages that are watched, seconds; duties are not told by themselves.
PERIODS = {"WheelTicks": 0.02, "Velocity": 0.02, "MotorDuty": 0.02, "Sonar": 0.02, "Battery": 0.1}


@dataclass(frozen=True)
class Moment:
    """SI units; None for what was not told yet. ranges: left, centre, right, None without an echo; sonars: their state.

    lost: frames of ours that the firmware missed, and of its own that were missed here.
    """

    time_s: float
    state: str = "Unknown"
    cause: str = "None"
    faults: tuple[str, ...] = ()
    emergency_stop: bool | None = None
    bumper: bool | None = None
    left_counts: int | None = None
    right_counts: int | None = None
    left_counts_per_s: float | None = None
    right_counts_per_s: float | None = None
    speed_m_s: float | None = None
    turning_rad_s: float | None = None
    wanted_speed_m_s: float | None = None
    wanted_turning_rad_s: float | None = None
    left_duty: float | None = None
    right_duty: float | None = None
    battery_v: float | None = None
    ranges_m: tuple[float | None, ...] = (None, None, None)
    sonars: tuple[str, ...] = ("Unknown", "Unknown", "Unknown")
    round_trip_ms: float | None = None
    lost: int = 0

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def rows(self) -> list[tuple[str, str]]:
        """For a person."""
        ranges = ", ".join(
            f"{name} {f'{distance:.2f} m' if distance is not None else state}"
            for name, distance, state in zip(SENSORS, self.ranges_m, self.sonars, strict=True)
        )
        return [
            ("time", f"{self.time_s:.1f} s"),
            ("state", f"{self.state} (last stop: {self.cause})"),
            ("faults", ", ".join(self.faults) or "none"),
            ("emergency stop", _word(self.emergency_stop, "pressed", "released")),
            ("bumper", _word(self.bumper, "pressed", "free")),
            ("counts", f"{_number(self.left_counts, '')} / {_number(self.right_counts, '')}"),
            ("counts/s", f"{_number(self.left_counts_per_s, '.0f')} / {_number(self.right_counts_per_s, '.0f')}"),
            ("speed", f"{_number(self.speed_m_s, '+.3f')} m/s, {_number(self.turning_rad_s, '+.2f')} rad/s"),
            (
                "wanted",
                f"{_number(self.wanted_speed_m_s, '+.3f')} m/s, {_number(self.wanted_turning_rad_s, '+.2f')} rad/s",
            ),
            ("duty", f"{_number(self.left_duty, '+.2f')} / {_number(self.right_duty, '+.2f')}"),
            ("ranges", ranges),
            ("battery", f"{_number(self.battery_v, '.2f')} V"),
            ("link", f"round trip {_number(self.round_trip_ms, '.1f')} ms, {self.lost} frames lost"),
        ]


def watch(link: Link, period: float, seconds: float) -> Iterator[Moment]:
    """A moment every `period` seconds for so many `seconds`. Raises LinkLost, SafetyStop."""
    for message, each in PERIODS.items():
        link.set_telemetry_period(message, each)
    begin = link.clock.now()
    moment, shown = Moment(0.0), Moment(0.0)
    due = begin + period
    while (now := link.clock.now()) - begin < seconds:
        for event in link.poll():
            moment = with_event(moment, event)
        if now >= due:
            due = max(due + period, now)
            trips = link.round_trips
            moment = timed(moment, shown, now - begin, trips[-1] * 1e3 if trips else None)
            shown = moment
            yield moment
        link.clock.advance(now + STEP_S)


def with_event(moment: Moment, event: Telemetry) -> Moment:
    """The moment with one more measurement."""
    match event:
        case WheelMotion():
            return replace(moment, left_counts=event.left_counts, right_counts=event.right_counts)
        case Velocity():
            return replace(
                moment,
                speed_m_s=event.measured_travel,
                turning_rad_s=event.measured_heading,
                wanted_speed_m_s=event.reference_travel,
                wanted_turning_rad_s=event.reference_heading,
            )
        case MotorDuty():
            return replace(moment, left_duty=event.left, right_duty=event.right)
        case Battery():
            return replace(moment, battery_v=event.voltage)
        case SonarRange() if event.sensor < len(SENSORS):
            ranges, states = list(moment.ranges_m), list(moment.sonars)
            ranges[event.sensor], states[event.sensor] = event.range_m, event.status
            return replace(moment, ranges_m=tuple(ranges), sonars=tuple(states))
        case FirmwareState():
            return replace(
                moment,
                state=event.state,
                cause=event.cause,
                faults=event.faults,
                emergency_stop=event.emergency_input,
                bumper=event.bumper,
            )
        case LinkQuality():
            return replace(moment, lost=event.lost)
        case _:
            return moment


def timed(moment: Moment, before: Moment, time: float, round_trip_ms: float | None) -> Moment:
    """The moment at that time, with the wheels' rates since the one before."""
    span = time - before.time_s
    rates: list[float | None] = []
    for name in ("left_counts", "right_counts"):
        there, then = getattr(moment, name), getattr(before, name)
        rates.append((there - then) / span if there is not None and then is not None and span > 0.0 else None)
    return replace(
        moment,
        time_s=time,
        left_counts_per_s=rates[0],
        right_counts_per_s=rates[1],
        round_trip_ms=round_trip_ms,
    )


def from_dict(told: Mapping[str, Any]) -> Moment:
    """The opposite of `as_dict`, after JSON. Raises KeyError."""
    values: dict[str, Any] = {}
    for field in fields(Moment):
        value = told[field.name]
        values[field.name] = tuple(value) if isinstance(value, list) else value
    return Moment(**values)


def _number(value: float | None, form: str) -> str:
    return "–" if value is None else f"{value:{form}}"


def _word(value: bool | None, yes: str, no: str) -> str:
    return "not told" if value is None else yes if value else no
