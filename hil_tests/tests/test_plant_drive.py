"""Motors, battery, encoders and slip of the simulated rover."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.vehicle import Vehicle
from rover_hil.testing.plants import NO_SLIP, SAME_MOTORS, drive, make_plant

VEHICLE = Vehicle()
RADIUS, TRACK, COUNTS = VEHICLE.wheel_radius, VEHICLE.track_width, VEHICLE.counts_per_revolution
EMF, RESISTANCE, COULOMB, VISCOUS = 0.5, 3.0, 0.04, 0.004
# Of one wheel when the rover drives straight: rotor and wheel, and half the rover's mass.
INERTIA = 8.0e-4 + 2.4 * RADIUS**2 / 2.0

PLAIN = {**NO_SLIP, **SAME_MOTORS}
# 7.4 V whatever is drawn.
FIRM_BATTERY = {"internal_resistance": 0.0, "base_current": 0.0, "capacity_ah": 1e6, "state_of_charge": 0.5}


def steady_speed(voltage: float) -> float:
    """Wheel speed in rad/s at which the motor's torque equals the friction."""
    return (EMF * voltage / RESISTANCE - COULOMB) / (EMF**2 / RESISTANCE + VISCOUS)


@pytest.mark.parametrize("duty", [0.2, 0.5, 1.0, -0.5])
def test_a_motor_settles_where_its_torque_equals_the_friction(duty: float) -> None:
    plant = make_plant(drive=PLAIN, battery=FIRM_BATTERY)
    drive(plant, duty, duty, 0.4)
    expected = math.copysign(steady_speed(abs(duty) * 7.4) * RADIUS, duty)
    assert plant.wheel_speeds() == pytest.approx((expected, expected), rel=1e-3)


def test_full_duty_gives_the_rovers_top_speed() -> None:
    assert steady_speed(7.4) * RADIUS == pytest.approx(0.45, abs=0.01)


def test_a_duty_below_the_friction_does_not_move_the_wheel() -> None:
    plant = make_plant(drive=PLAIN, battery=FIRM_BATTERY)
    drive(plant, 0.03, -0.03, 0.5)
    assert plant.encoders() == (0, 0)
    assert plant.pose() == (2.0, 2.0, 0.0)


def test_without_power_the_wheels_coast_down_by_friction_alone() -> None:
    plant = make_plant(drive=PLAIN, battery=FIRM_BATTERY)
    drive(plant, 0.6, 0.6, 0.4)
    start = plant.wheel_speeds()[0] / RADIUS
    # I w' = -(viscous w + Coulomb): the wheel stands still after this time.
    expected = INERTIA / VISCOUS * math.log1p(VISCOUS * start / COULOMB)
    elapsed = 0
    while plant.wheel_speeds()[0] > 0.0:
        plant.step(0.6, 0.6, False)
        elapsed += 1
        assert elapsed < 5000
    assert elapsed * 1e-3 == pytest.approx(expected, rel=0.02)
    assert plant.wheel_speeds() == (0.0, 0.0)


def test_powered_at_zero_duty_brakes_harder_than_coasting() -> None:
    braked, coasting = (make_plant(drive=PLAIN, battery=FIRM_BATTERY) for _ in range(2))
    for plant, powered in ((braked, True), (coasting, False)):
        drive(plant, 0.6, 0.6, 0.4)
        for _ in range(30):
            plant.step(0.0, 0.0, powered)
    assert braked.wheel_speeds()[0] < 0.5 * coasting.wheel_speeds()[0]


def test_the_battery_sags_under_load_and_empties_slowly() -> None:
    plant = make_plant()
    idle, charge = plant.battery()
    plant.step(1.0, 1.0, True)
    loaded, _ = plant.battery()
    assert 0.4 < idle - loaded < 1.2  # two stalled motors, 2.6 A each, over 0.15 ohm
    drive(plant, 0.0, 0.0, 20.0)
    assert charge - plant.battery()[1] == pytest.approx(0.9 * 20.0 / (2.6 * 3600.0), rel=0.1)


def test_one_wheel_revolution_is_1560_counts() -> None:
    plant = make_plant(drive=PLAIN)
    drive(plant, 0.3, 0.3, 2.0)
    left, right = plant.wheel_angles()
    assert plant.encoders() == (math.floor(left / math.tau * COUNTS), math.floor(right / math.tau * COUNTS))
    assert left > math.tau / 2


def dead_reckoning(drive_config: dict[str, float], seed: int) -> tuple[float, float]:
    """Drives an S; returns the error of wheel odometry at the end and the length of the way."""
    plant = make_plant(drive=drive_config, seed=seed)
    x, y, heading = plant.pose()
    travelled = 0.0
    before = np.array(plant.encoders())
    for duties in ((0.5, 0.3), (0.3, 0.5), (0.5, 0.5)):
        for _ in range(2000):
            plant.step(*duties, True)
            counts = np.array(plant.encoders())
            left, right = (counts - before) * (math.tau * RADIUS / COUNTS)
            before = counts
            travel, turn = 0.5 * (left + right), (right - left) / TRACK
            x += travel * math.cos(heading + 0.5 * turn)
            y += travel * math.sin(heading + 0.5 * turn)
            heading += turn
            travelled += travel
    true_x, true_y, _ = plant.pose()
    return math.hypot(x - true_x, y - true_y), travelled


def test_without_slip_wheel_odometry_is_the_truth() -> None:
    error, _ = dead_reckoning(PLAIN, seed=1)
    assert error < 0.001


def test_with_slip_wheel_odometry_drifts_by_a_few_percent() -> None:
    drifts = [error / travelled for error, travelled in (dead_reckoning({}, seed) for seed in range(8))]
    assert 0.002 < np.median(drifts) < 0.08
    assert max(drifts) < 0.2


def test_each_seed_has_slip_of_its_own_within_its_bound() -> None:
    slips = [make_plant(seed=seed).slip() for seed in range(40)]
    assert len(set(slips)) == 40
    assert np.abs(slips).max() <= 0.03 + 1e-12
    assert np.abs(slips).max() > 0.015


def test_the_same_seed_gives_the_same_bytes() -> None:
    def run(seed: int) -> tuple[bytes, list[bytes]]:
        plant = make_plant(seed=seed)
        drive(plant, 0.5, 0.4, 1.0)
        return plant.truth().tobytes(), [frame[4] for frame in plant.take_frames()]

    assert run(7) == run(7)
    assert run(7)[0] != run(8)[0]
    assert run(7)[1] != run(8)[1]


def test_a_wrong_configuration_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"drive\.resistance must be positive"):
        make_plant(drive={"resistance": 0.0})
    with pytest.raises(ValueError, match="unknown field `dirve`"):
        make_plant(dirve={})
    with pytest.raises(ValueError, match=r"camera\.period_us must be whole ms"):
        make_plant(camera={"period_us": 119_999})
