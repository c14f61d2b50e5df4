"""Bring-up of a rover that is built otherwise than its board and its file believe: what it really is, is found."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from rover.bringup.session import Done, bring_up, chosen, load_notes, report_of
from rover.link.parameters import read_parameters
from rover.vehicle import load_vehicle
from rover.vehicle.difference import differences
from rover_hil.testing.bench_rig import BenchRig

pytestmark = pytest.mark.rig("sitl")

BUILT = """
[wheels]
track_m = 0.213
radius_m = 0.034
right_radius_m = 0.0336
counts_per_revolution = 1400
[battery]
divider_scale = 1.2
[wiring]
left_motor_inverted = true
right_encoder_inverted = true
encoders_swapped = true
sonars = ["right", "left", "centre"]
"""


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[BenchRig]:
    file = tmp_path / "built.toml"
    file.write_text(BUILT, encoding="utf-8")
    rig = BenchRig(file, tmp_path / "memory", exact=True)
    rig.link.connect()
    yield rig
    rig.close()


def brought_up(rig: BenchRig, file: Path, names: Sequence[str], made: Sequence[Done] = ()) -> dict[str, Done]:
    return {done.name: done for done in bring_up(rig.link, rig.helper, file, names, made)}


@pytest.mark.slow
def test_every_constant_that_differs_is_recovered(bench: BenchRig, tmp_path: Path) -> None:
    file = tmp_path / "vehicle.toml"
    names = chosen(None, [])
    done = brought_up(bench, file, names)
    assert [name for name in names if not done[name].ok] == []
    found, built = load_vehicle(file), load_vehicle(tmp_path / "built.toml")
    assert found.wheel_radius == pytest.approx(built.wheel_radius, rel=0.01)
    assert found.right_wheel_radius == pytest.approx(built.right_wheel_radius, rel=0.01)
    assert found.track_width == pytest.approx(built.track_width, rel=0.01)
    assert found.counts_per_revolution == built.counts_per_revolution
    values, true = found.parameters(), built.parameters()
    assert values["battery_scale"] == pytest.approx(true["battery_scale"], rel=0.01)
    assert (values["wiring"], values["sonar_order"]) == (true["wiring"], true["sonar_order"])
    static, velocity, acceleration = drive_of(bench)
    assert values["feed_static"] == pytest.approx(static * 32767, rel=0.03)
    assert values["feed_velocity"] == pytest.approx(velocity * 32767, rel=0.01)
    assert values["feed_acceleration"] == pytest.approx(acceleration * 32767, rel=0.05)
    # The board has all of it, and keeps it.
    assert differences(values, read_parameters(bench.link)) == []
    page = report_of(file).read_text(encoding="utf-8")
    assert "left motor is inverted" in page
    assert "FAILED" not in page
    # Whoever calls again has nothing left to do.
    assert chosen(None, load_notes(file)) == []


def drive_of(bench: BenchRig) -> tuple[float, float, float]:
    """Feed-forward by the plant's constants, the mean of both motors: duty of 7.4 V."""
    volts, radius, mass, inertia, friction, viscous = 7.4, 0.0338, 2.4, 8.0e-4, 0.04, 0.004
    resistance, back_emf = 3.0, 0.5
    to_duty = resistance / back_emf / volts
    static = friction * to_duty
    velocity = (viscous + back_emf**2 / resistance) * to_duty / radius
    acceleration = (inertia + 0.5 * mass * radius**2) * to_duty / radius
    return static, velocity, acceleration


@pytest.mark.parametrize(
    ("broken", "step", "says"),
    [
        ({"encoders_dead": [True, False]}, "wheels", "the left wheel turns and its encoder counts nothing"),
        ({"motors_dead": [False, True]}, "wheels", "the right output turns nothing: motor wire, bridge"),
        ({"sonars_dead": [False, True, False]}, "sonars", "the sensor on the right pins is dead: supply, trigger"),
        ({"battery_scale": 0.3}, "supply", "wrong resistors"),
    ],
)
def test_what_only_hands_can_mend_is_named(tmp_path: Path, broken: dict[str, Any], step: str, says: str) -> None:
    built = tmp_path / "built.toml"
    built.write_text(BUILT, encoding="utf-8")
    rig = BenchRig(built, tmp_path / "memory", broken=broken)
    try:
        rig.link.connect()
        done = brought_up(rig, tmp_path / "vehicle.toml", [step])[step]
    finally:
        rig.close()
    assert not done.ok
    assert says in done.message, done.message
    # Nothing of it has gone into the file, and the next call makes the step again.
    assert step in chosen(None, load_notes(tmp_path / "vehicle.toml"))


def test_the_command_makes_the_steps_that_are_asked_for(tmp_path: Path) -> None:
    from rover_hil.testing.served import ServedRig

    built = tmp_path / "built.toml"
    built.write_text(BUILT, encoding="utf-8")
    rig = ServedRig("bench", "--free-run", "--no-camera", "--vehicle", str(built))
    try:
        file = tmp_path / "vehicle.toml"
        options = ("--port", rig.port, "--vehicle", str(file), "--steps", "supply,stop", "--json")
        command = [sys.executable, "-m", "rover.cli.main", "bringup", *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        told = json.loads(done.stdout)
        assert [(step["name"], step["ok"]) for step in told["steps"]] == [("supply", True), ("stop", True)]
        assert told["steps"][0]["found"]["divider_scale"] == pytest.approx(1.2, abs=0.01)
        assert told["vehicle"] == str(file)
        assert load_vehicle(file).parameters()["battery_scale"] == pytest.approx(1_200_000, rel=0.01)
    finally:
        rig.stop()
