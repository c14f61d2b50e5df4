"""The steps of a bring-up: each measures, says what it has found, and proposes values for the vehicle file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rover.bringup import feed_forward, gains, geometry, sonars, wiring
from rover.bringup.bench import Bench, Run, StepFailed
from rover.bringup.helper import Helper
from rover.link.jogging import Wish
from rover.vehicle import Vehicle
from rover.vehicle.firmware import SENSORS, entries, shortest

# Volts of a lithium-ion cell that is neither harmed nor overcharged.
CELL_V = (3.0, 4.25)
# Of a divider that needs no correction.
DIVIDER_SHARE = 0.01
PULSE_DUTY, PULSE_S = 0.35, 0.5
FEED_DUTIES, FEED_S = (0.2, 0.3, 0.4, 0.5), 0.8
BOX_M = (0.25, 0.5)
STRAIGHT_M_S, STRAIGHT_M, STRAIGHT_RUNS = 0.15, 1.2, 3
TURN_RAD_S, TURNS = 1.0, 5
EMERGENCY_S = 3.0


@dataclass(frozen=True)
class Outcome:
    """ok: nothing is left to be put right by hand. entries: (table, key, literal) for the vehicle file."""

    ok: bool
    message: str
    found: Mapping[str, Any] = field(default_factory=dict)
    measured: Mapping[str, Any] = field(default_factory=dict)
    entries: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True)
class Setting:
    """What a step has: the rover at its bench, whoever stands beside it, and the vehicle as its file has it by now."""

    bench: Bench
    helper: Helper
    vehicle: Vehicle


def supply(at: Setting) -> Outcome:
    """The board's voltage against a meter's: the divider."""
    at.bench.set({"battery_scale": 1_000_000})
    read = at.bench.voltage()
    if read is None or read < 0.5:
        return Outcome(False, "the board tells no battery voltage: the divider, or its wire to the converter")
    true = at.helper.volts()
    scale = true / read
    cell = true / at.vehicle.pack.cells
    found = {"divider_scale": round(scale, 4)}
    measured = {"read_v": round(read, 3), "meter_v": round(true, 3), "cell_v": round(cell, 3)}
    if not CELL_V[0] <= cell <= CELL_V[1]:
        cells = f"{at.vehicle.pack.cells} cells in series have {CELL_V[0] * at.vehicle.pack.cells:g} to "
        wanted = f"{cells}{CELL_V[1] * at.vehicle.pack.cells:g} V"
        return Outcome(
            False, f"{true:.2f} V: {wanted}; charge the battery, or mend cells in [battery]", found, measured
        )
    if not 0.5 <= scale <= 2.0:
        return Outcome(False, f"the board reads {read:.2f} V of {true:.2f} V: wrong resistors", found, measured)
    off = 100.0 * (1.0 / scale - 1.0)
    message = f"{true:.2f} V; the board reads {off:+.1f} %" + (": put right" if abs(off) > 100 * DIVIDER_SHARE else "")
    return Outcome(True, message, found, measured, (("battery", "divider_scale", f"{scale:.4f}"),))


def stop(at: Setting) -> Outcome:
    """The emergency stop, pressed and released."""

    def becomes(pressed: bool) -> bool:
        begin = at.bench.link.clock.now()
        while at.bench.link.clock.now() - begin < EMERGENCY_S:
            at.bench.wait(0.1)
            state = at.bench.link.state
            if state is not None and state.emergency_input == pressed:
                return True
        return False

    if not becomes(False):
        return Outcome(
            False, "the board believes that the emergency stop is pressed: its loop is open, or it is pressed"
        )
    at.helper.emergency(True)
    felt = becomes(True)
    at.helper.emergency(False)
    if not felt:
        return Outcome(False, "pressing the emergency stop changes nothing: its contact is bridged, or not in the loop")
    if not becomes(False):
        return Outcome(False, "the emergency stop stays pressed: a contact that does not close again")
    return Outcome(True, "felt when pressed and when released", {"pressed": True, "released": True})


def wheels(at: Setting) -> Outcome:
    """Which motor is on which output, which encoder on which input, and their directions."""
    at.helper.ready("wheels in the air: both will turn, one after the other")
    at.bench.set({"wiring": 0})
    at.bench.open_loop()
    pulses = []
    for output in (0, 1):
        before = at.helper.before()
        duties = (PULSE_DUTY, 0.0) if output == 0 else (0.0, PULSE_DUTY)
        run = at.bench.by_duty(*duties, PULSE_S)
        if run.cause not in ("None", "Stall", "EncoderFault"):
            return Outcome(False, f"the run has ended: {run.cause}")
        pulses.append(wiring.Pulse(output, at.helper.moved(before), run.counts))
    judged = wiring.judge((pulses[0], pulses[1]))
    measured = {f"{wiring.WHEELS[p.output]}_output": {"turned": p.seen, "counts": list(p.counts)} for p in pulses}
    found = {"wiring": judged.bits, "faults": list(judged.faults)}
    put_right = tuple(entries("wiring", judged.bits, at.vehicle))
    if judged.faults:
        return Outcome(False, "; ".join(judged.faults), found, measured)
    return Outcome(True, "; ".join(judged.told) + (": put right" if judged.bits else ""), found, measured, put_right)


def counts(at: Setting) -> Outcome:
    """Counts of a wheel's turn, by turns that somebody has counted."""
    at.helper.ready("wheels in the air: both turn; count the turns of a mark on each tyre")
    at.bench.open_loop()
    before = at.helper.before()
    run = at.bench.by_duty(PULSE_DUTY, PULSE_DUTY, 4.0)
    turns = at.helper.turns(before)
    if min(abs(turn) for turn in turns) < 0.5:
        return Outcome(False, "the wheels have hardly turned", measured={"turns": list(turns)})
    each = [count / turn for count, turn in zip(run.counts, turns, strict=True)]
    measured = {"counts": list(run.counts), "turns": [round(turn, 3) for turn in turns]}
    if abs(each[0] / each[1] - 1.0) > 0.02 or min(each) <= 0.0:
        return Outcome(
            False, f"{each[0]:.0f} counts a turn left and {each[1]:.0f} right: one encoder loses edges", {}, measured
        )
    whole = round(0.5 * sum(each))
    at_once = ("wheels", "counts_per_revolution", str(whole))
    return Outcome(True, f"{whole} counts a turn", {"counts_per_revolution": whole}, measured, (at_once,))


def drive(at: Setting) -> Outcome:
    """Feed-forward and dead band, from runs by duty in both directions."""
    at.bench.open_loop()
    runs: list[Run] = []
    for duty in FEED_DUTIES:
        at.helper.ready("wheels in the air, or 1.5 m free ahead: runs of one second, forth and back")
        for sign in (1.0, -1.0):
            run = at.bench.by_duty(sign * duty, sign * duty, FEED_S)
            if run.cause != "None":
                return Outcome(False, f"the run with duty {sign * duty:+.2f} has ended: {run.cause}")
            runs.append(run)
    try:
        fitted = feed_forward.fit(runs, at.vehicle.wheel_scales, at.vehicle.track_width)
    except ValueError as error:
        return Outcome(False, str(error))
    found = {
        "static_duty": round(fitted.static, 5),
        "duty_per_m_s": round(fitted.velocity, 5),
        "duty_per_m_s2": round(fitted.acceleration, 5),
        "highest_speed_m_s": round(fitted.speed, 3),
    }
    measured = {"sigma": [round(value, 6) for value in fitted.sigma], "dead_band_duty": round(fitted.dead_band, 4)}
    if fitted.static < 0.0 or fitted.velocity <= 0.0:
        return Outcome(
            False, "more duty does not give more speed: wheels that slip, or encoders that lose edges", found
        )
    names = ("static_duty", "duty_per_m_s", "duty_per_m_s2")
    values = (fitted.static, fitted.velocity, max(fitted.acceleration, 0.0))
    put = tuple(
        ("drive", name, shortest(round(value * 32767.0), 32767.0)) for name, value in zip(names, values, strict=True)
    )
    message = f"{fitted.static:.3f} of duty against friction, {fitted.speed:.2f} m/s at full duty"
    return Outcome(True, message, found, measured, put)


def pid(at: Setting) -> Outcome:
    """Gains of the speed loop for that drive, their margins, and how a step of speed follows."""
    values = at.vehicle.parameters()
    drive_of = feed_forward.FeedForward(
        values["feed_static"] / 32767.0,
        values["feed_velocity"] / 32767.0,
        values["feed_acceleration"] / 32767.0,
        (0.0, 0.0, 0.0),
        0.0,
        0.0,
    )
    tuned = gains.tuned(drive_of)
    wanted = {"gain_velocity": round(tuned.velocity * 32767.0), "gain_integral": round(tuned.integral * 32767.0)}
    at.helper.ready("wheels in the air, or 1.5 m free ahead: one run at 0.15 m/s")
    at.bench.set({**wanted, "guard_enabled": 0})
    run = at.bench.by_speed(Wish(STRAIGHT_M_S, 0.0), 2.0)
    scale = at.vehicle.metres_per_count
    errors = [
        run.commanded(event.time).travel
        - 0.5
        * scale
        * (event.left_counts + event.right_counts - run.wheels[0].left_counts - run.wheels[0].right_counts)
        for event in run.wheels
    ]
    worst = max(map(abs, errors), default=math.inf)
    found = {"velocity_gain": round(tuned.velocity, 4), "integral_gain": round(tuned.integral, 4)}
    measured = {
        "phase_margin_deg": round(tuned.phase_margin_deg, 1),
        "gain_margin": round(tuned.gain_margin, 2),
        "delay_margin_ms": round(tuned.delay_margin_s * 1e3, 1),
        "worst_following_error_mm": round(worst * 1e3, 1),
    }
    if run.cause != "None":
        return Outcome(False, f"the run with these gains has ended: {run.cause}", found, measured)
    put = tuple(entry for name, value in wanted.items() for entry in entries(name, value, at.vehicle))
    margins = f"phase margin {tuned.phase_margin_deg:.0f}°, gain margin {tuned.gain_margin:.1f}"
    message = f"{margins}, {worst * 1e3:.1f} mm behind at most"
    return Outcome(True, message, found, measured, put)


def ranges(at: Setting) -> Outcome:
    """Which sensor is on which pins, at two distances of a box."""
    at.bench.set({"sonar_order": 0})
    boxes = []
    for sensor in range(len(SENSORS)):
        for distance in BOX_M:
            at.helper.box(sensor, distance)
            boxes.append(sonars.Boxed(sensor, distance, at.bench.ranges()))
    at.helper.no_box()
    judged = sonars.judge(boxes)
    measured = {
        f"{SENSORS[boxed.sensor]} {boxed.distance:g} m": [
            next((event.range_m for event in reversed(said) if event.range_m is not None), None) for said in boxed.said
        ]
        for boxed in boxes
    }
    found = {"sonar_order": judged.order, "scale": None if judged.scale is None else round(judged.scale, 3)}
    if judged.faults or judged.order is None:
        return Outcome(False, "; ".join(judged.faults) or "the sensors cannot be told apart", found, measured)
    put = tuple(entries("sonar_order", judged.order, at.vehicle))
    return Outcome(True, "; ".join(judged.told) + (": put right" if judged.order else ""), found, measured, put)


def rolling(at: Setting) -> Outcome:
    """Track and both radii: straight runs, and turns to either side."""
    at.bench.set({"guard_enabled": 0})
    rolled: list[geometry.Rolled] = []
    half_s = 2.0 * 0.4
    for _ in range(STRAIGHT_RUNS):
        at.helper.ready(f"on the floor, {STRAIGHT_M + 0.3:g} m free ahead; mark where it stands")
        for sign in (1.0, -1.0):
            before = at.helper.before()
            run = at.bench.by_speed(Wish(sign * STRAIGHT_M_S, 0.0), STRAIGHT_M / STRAIGHT_M_S - half_s)
            _whole(run)
            way, turned = at.helper.straight(before)
            rolled.append(geometry.Rolled(run.counts, sign * way, turned))
    at.helper.ready("on the floor, with room to turn; mark its heading")
    for sign in (1.0, -1.0):
        before = at.helper.before()
        angle = 2.0 * math.pi * TURNS
        run = at.bench.by_speed(Wish(0.0, sign * TURN_RAD_S), angle / TURN_RAD_S - half_s)
        _whole(run)
        left, right = (count * scale for count, scale in zip(run.counts, at.vehicle.wheel_scales, strict=True))
        about = (right - left) / at.vehicle.track_width
        rolled.append(geometry.Rolled(run.counts, None, at.helper.rotation(before, about)))
    start = at.vehicle.wheel_radius, at.vehicle.right_wheel_radius, at.vehicle.track_width
    try:
        fitted = geometry.fit(rolled, at.vehicle.counts_per_revolution, start)
    except ValueError as error:
        return Outcome(False, str(error))
    found = {
        "radius_m": round(fitted.left_radius, 6),
        "right_radius_m": round(fitted.right_radius, 6),
        "track_m": round(fitted.track, 5),
    }
    measured = {"sigma_m": [round(value, 6) for value in fitted.sigma], "runs": len(rolled)}
    put = (
        ("wheels", "radius_m", f"{fitted.left_radius:.6f}"),
        ("wheels", "right_radius_m", f"{fitted.right_radius:.6f}"),
        ("wheels", "track_m", f"{fitted.track:.5f}"),
    )
    radii = f"radii {fitted.left_radius * 1e3:.2f} and {fitted.right_radius * 1e3:.2f} ± {fitted.sigma[0] * 1e3:.2f} mm"
    return Outcome(
        True, f"{radii}, track {fitted.track * 1e3:.1f} ± {fitted.sigma[2] * 1e3:.1f} mm", found, measured, put
    )


def _whole(run: Run) -> None:
    if run.cause != "None":
        raise StepFailed(f"a run has ended before its time: {run.cause}")


STEPS: Mapping[str, Callable[[Setting], Outcome]] = {
    "supply": supply,
    "stop": stop,
    "wheels": wheels,
    "counts": counts,
    "sonars": ranges,
    "geometry": rolling,
    "drive": drive,
    "pid": pid,
}
"""In the order in which they build on each other: a feed-forward is one for metres, so the radii come before it."""
