"""What keeps a rover from setting off, and what does not."""

from __future__ import annotations

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.errors import PreflightFailed
from rover.link.inquiry import Told
from rover.link.self_test import Finding
from rover.link.telemetry import Battery, FirmwareState
from rover.mission.preflight import Preflight, judge_disk, judge_firmware, judge_pictures
from rover.vision.camera.file import load_camera

CAMERA = load_camera("lepton-160")
SONARS = {0: "NoEcho", 1: "Ok", 2: "Ok"}


def told(state="Disarmed", cause="None", faults=(), pressed=False, volts=7.5, sonars=SONARS) -> Told:
    firmware = FirmwareState(0.0, state, cause, 0, tuple(faults), 7, True, pressed, False, False)
    return Told(firmware, None if volts is None else Battery(0.0, volts, volts), sonars)


def failed(answer: Told) -> list[str]:
    return [finding.name for finding in judge_firmware(answer) if not finding.ok]


def test_a_rover_that_has_just_started_may_set_off():
    assert failed(told()) == []


def test_one_that_was_stopped_may_set_off_again():
    assert failed(told("Latched", "DeadMan", ["DeadMan"])) == []
    assert failed(told("Latched", "Stall", ["Stall", "SonarGuard"])) == []


@pytest.mark.parametrize(
    ("answer", "names"),
    [
        (told(pressed=True), ["emergency stop"]),
        (told(faults=["LowBattery"]), ["faults", "battery"]),
        (told(volts=None), ["battery"]),
        (told("Moving"), ["state"]),
        (told(faults=["EncoderLeft"]), ["faults"]),
        (told(sonars={0: "Ok", 1: "Dead", 2: "Ok"}), ["sonar centre"]),
        (told(sonars={0: "Ok", 1: "Ok"}), ["sonar right"]),
    ],
)
def test_what_is_wrong_keeps_it(answer, names):
    assert failed(answer) == names


def pictures(count=5, period=0.115, size=(160, 120), unit=0.01, middle=29300, low=0) -> list[Frame]:
    """Ground around `middle` counts with 5 counts of noise; `low` is taken off all of them."""
    rng = np.random.default_rng(4)
    noisy = [(rng.normal(middle, 5.0, size[::-1]).round() - low).astype(np.uint16) for _ in range(count)]
    return [Frame(each, 10.0 + period * n, n, kelvin_per_count=unit) for n, each in enumerate(noisy)]


@pytest.mark.parametrize(
    ("taken", "age", "words"),
    [
        (pictures(2), 0.1, "2 pictures within"),
        (pictures(size=(80, 60)), 0.1, "gives 80×60, the mission's lepton-160 has 160×120"),
        (pictures(unit=None), 0.1, "raw counts"),
        (pictures(low=22000), 0.1, "no picture to go by: raw counts of 14 bits"),
        (pictures(middle=40000), 0.1, "°C are no temperatures of ground"),
        (pictures(2) + pictures(3, middle=32000), 0.1, "temperatures change by +27 K from one picture to the next"),
        (pictures(period=0.5), 0.1, "2.0 pictures a second"),
        (pictures(), 3.0, "3.00 s old"),
        (pictures(), -8.0, "its clock is not the system's"),
    ],
)
def test_a_camera_that_will_not_do(taken, age, words):
    finding = judge_pictures(taken, [age] * len(taken), CAMERA)
    assert not finding.ok
    assert words in finding.detail


def test_a_camera_that_will_do():
    finding = judge_pictures(pictures(), [0.08] * 5, CAMERA)
    assert finding.ok
    assert "8.7 pictures a second, 80 ms old" in finding.detail


def test_the_disk_must_hold_the_longest_log():
    needed = judge_disk(0, 900.0, CAMERA)
    assert not needed.ok
    assert "401 MB" in needed.detail
    assert judge_disk(500_000_000, 900.0, CAMERA).ok


def test_what_has_failed_is_named_and_the_exit_code_says_so():
    findings = (Finding("battery", False, "6.0 V is too low"), Finding("disk", True, ""), Finding("camera", False, ""))
    with pytest.raises(PreflightFailed, match="battery, camera") as error:
        Preflight(findings).require()
    assert error.value.exit_code == 3
    Preflight(findings[1:2]).require()
