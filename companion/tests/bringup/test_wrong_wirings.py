"""Wrong wirings, each named for what it is, and those that software can put right put right."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from rover.bringup import sonars
from rover.bringup.feed_forward import FeedForward
from rover.bringup.gains import margins, tuned
from rover.bringup.geometry import Rolled, fit
from rover.bringup.wiring import Pulse, judge
from rover.link.telemetry import SonarRange
from rover.vehicle.firmware import ORDERS, SENSORS

COUNTS = 1000


def pulses(
    bits: int, motors: tuple[bool, bool] = (True, True), encoders: tuple[bool, bool] = (True, True)
) -> tuple[Pulse, Pulse]:
    """What is seen and counted on a rover with that wiring; False: a motor or an encoder without a connection."""
    found = []
    for output in (0, 1):
        wheel = 1 - output if bits & 16 else output
        forward = not bits & 1 << wheel
        counts = [0, 0]
        if motors[wheel] and encoders[wheel]:
            up = forward != bool(bits & 4 << wheel)
            counts[1 - wheel if bits & 32 else wheel] = COUNTS if up else -COUNTS
        seen = f"{('left', 'right')[wheel]} {'forward' if forward else 'back'}" if motors[wheel] else "nothing"
        found.append(Pulse(output, seen, (counts[0], counts[1])))
    return found[0], found[1]


@pytest.mark.parametrize("bits", range(64))
def test_each_way_to_cross_and_invert_wheels_is_told_apart(bits: int) -> None:
    found = judge(pulses(bits))
    assert (found.bits, found.faults) == (bits, ())
    assert len(found.told) == max(bin(bits).count("1"), 1)


WRONG = {
    "left motor off": (
        pulses(0, motors=(False, True)),
        "the left output turns nothing: motor wire, bridge or its supply",
    ),
    "right motor off": (pulses(0, motors=(True, False)), "the right output turns nothing"),
    "left motor off, crossed": (pulses(16, motors=(False, True)), "the right output turns nothing"),
    "no motor supply": (pulses(0, motors=(False, False)), "the right output turns nothing"),
    "left encoder off": (pulses(0, encoders=(False, True)), "the left wheel turns and its encoder counts nothing"),
    "right encoder off": (pulses(0, encoders=(True, False)), "the right wheel turns and its encoder counts nothing"),
    "right encoder off, crossed": (pulses(32, encoders=(True, False)), "the right wheel turns and its encoder"),
    "no encoder supply": (pulses(0, encoders=(False, False)), "the right wheel turns and its encoder counts nothing"),
    "encoders in parallel": (
        (Pulse(0, "left forward", (COUNTS, COUNTS)), Pulse(1, "right forward", (COUNTS, COUNTS))),
        "the left wheel turns and both encoders count",
    ),
    "one input for both": (
        (Pulse(0, "left forward", (COUNTS, 0)), Pulse(1, "right forward", (COUNTS, 0))),
        "one input counts for both wheels",
    ),
    "motors in parallel": (
        (Pulse(0, "left forward", (COUNTS, 0)), Pulse(1, "left forward", (COUNTS, 0))),
        "both outputs turn the left wheel: the motors are wired in parallel",
    ),
    "looked at the wrong moment": (
        (Pulse(0, "nothing", (COUNTS, 0)), Pulse(1, "right forward", (0, COUNTS))),
        "the left output: an encoder counts, but no wheel was seen to turn",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_only_hands_can_mend_is_named(name: str) -> None:
    seen, says = WRONG[name]
    assert any(says in fault for fault in judge(seen).faults), judge(seen).faults


def said(*ranges: float | None, status: str = "NoEcho") -> list[list[SonarRange]]:
    """A range, or a status, of the left, centre and right pins."""
    return [[SonarRange(0.0, pins, at, "Ok" if at is not None else status)] * 5 for pins, at in enumerate(ranges)]


def boxes(order: int) -> list[sonars.Boxed]:
    found = []
    for sensor, distance in itertools.product(range(3), (0.25, 0.5)):
        ranges = [distance if ORDERS[order][pins] == SENSORS[sensor] else None for pins in range(3)]
        found.append(sonars.Boxed(sensor, distance, said(*ranges)))
    return found


@pytest.mark.parametrize("order", range(6))
def test_each_order_of_sonars_is_told_apart(order: int) -> None:
    found = sonars.judge(boxes(order))
    assert (found.order, found.faults) == (order, ())


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (sonars.Boxed(0, 0.25, said(0.25, 0.26, None)), "is seen on the left and centre pins: cross-talk"),
        (sonars.Boxed(0, 0.25, said(None, None, None)), "nobody sees the box at 0.25 m before the left sensor"),
        (sonars.Boxed(0, 0.25, [[], *said(None, None)[:2]]), "the left pins say nothing: is the sensor fitted"),
    ],
)
def test_a_sonar_that_only_hands_can_mend_is_named(wrong: sonars.Boxed, says: str) -> None:
    found = sonars.judge([wrong])
    assert any(says in fault for fault in found.faults), found.faults


def test_ranges_that_are_too_long_by_a_share_are_named() -> None:
    long = [
        sonars.Boxed(b.sensor, b.distance, said(*(b.distance * 1.1 if s[0].range_m else None for s in b.said)))
        for b in boxes(0)
    ]
    assert any("+10 % off" in fault for fault in sonars.judge(long).faults)


@pytest.mark.parametrize("seed", range(5))
def test_radii_and_track_are_found_within_what_they_are_said_to_be_off(seed: int) -> None:
    """Straight runs and turns with slip: 3 sigma hold in each of five draws."""
    random = np.random.default_rng(seed)
    true = np.array([0.034 + 0.001 * random.normal(), 0.034 + 0.001 * random.normal(), 0.2 + 0.01 * random.normal()])
    runs = []
    for left, right in [(1.2, 1.2), (-1.2, -1.2)] * 3 + [(-3.1, 3.1), (3.1, -3.1)]:
        ways = np.array([left, right]) * (1.0 + 0.002 * random.normal(size=2))
        counts = [round(way / (2.0 * math.pi * radius) * 1560) for way, radius in zip(ways, true[:2], strict=True)]
        straight = left == right
        heading = (right - left) / true[2]
        runs.append(Rolled((counts[0], counts[1]), 0.5 * (left + right) if straight else None, heading))
    found = fit(runs, 1560, (0.0325, 0.0325, 0.2))
    for got, wanted, sigma in zip((found.left_radius, found.right_radius, found.track), true, found.sigma, strict=True):
        assert abs(got - wanted) < 3.0 * sigma < 0.015 * wanted


def test_a_straight_run_alone_does_not_tell_the_track() -> None:
    with pytest.raises(ValueError, match="straight runs and turns are both needed"):
        fit([Rolled((9000, 9000), 1.2, 0.0)], 1560, (0.0325, 0.0325, 0.2))


def test_margins_are_those_of_the_loop_by_its_closed_form() -> None:
    """An integrator behind a pure gain: crossing at K, phase margin 90° less the delay's share."""
    phase, gain, delay = margins(0.0, 20.0, 1e-9, 1.0)
    assert phase == pytest.approx(90.0 - math.degrees(20.0 * 0.010), abs=0.2)
    assert gain == pytest.approx(math.pi / 2.0 / 0.010 / 20.0, rel=0.01)
    assert delay == pytest.approx(math.radians(phase) / 20.0, rel=0.01)


@pytest.mark.parametrize("acceleration", [0.02, 0.08, 0.3])
def test_gains_leave_room_for_a_drive_that_is_otherwise(acceleration: float) -> None:
    found = tuned(FeedForward(0.05, 2.1, acceleration, (0.0, 0.0, 0.0), 0.05, 0.45))
    assert found.phase_margin_deg > 60.0
    assert found.gain_margin > 2.0
