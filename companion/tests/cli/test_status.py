"""`rover status` and `rover doctor --port` against the real firmware in a free-running rig."""

from __future__ import annotations

import json

import pytest
from rover.link.firmware_document import CAUSES, in_words
from rover.link.telemetry import FirmwareState
from rover_protocol import messages


def state(name: str, cause: str) -> FirmwareState:
    return FirmwareState(0.0, name, cause, 0, (), 0, True, False, False, False)


@pytest.mark.parametrize(
    ("name", "cause", "words"),
    [
        ("Latched", "DeadMan", "latched: the dead-man stopped it, nothing was heard from the companion"),
        ("Disarmed", "None", "disarmed"),
        ("Disarmed", "StopCommand", "disarmed; last stop: it was told to stop"),
        ("Latched", "Unknown77", "latched: cause Unknown77, which this version does not know"),
    ],
)
def test_state_and_cause_in_words(name, cause, words):
    assert in_words(state(name, cause)) == words


def test_every_cause_of_the_protocol_has_words():
    assert set(CAUSES) == set(messages.VALUES["State"]["cause"].values())


@pytest.fixture(scope="module", params=["serial", "can"])
def port(free_rig, request):
    return free_rig(request.param)


@pytest.mark.rig("sitl")
def test_a_firmware_that_never_crashed_says_so(rover, port):
    assert json.loads(rover("status", "--port", port, "--crash", "--json").out) == {"cause": None}
    assert "no crash is recorded" in rover("status", "--port", port, "--crash", "--clear").out


@pytest.mark.rig("sitl")
def test_a_firmware_tells_who_and_how_it_is(rover, port):
    result = rover("status", "--port", port, "--json")
    told = json.loads(result.out)
    assert result.code == 0
    assert (told["board"], told["state"], told["cause"], told["meaning"]) == ("Sitl", "Disarmed", "None", "disarmed")
    assert told["schema_hash"] == f"{messages.SCHEMA_HASH:08x}"
    assert 6.0 < told["battery_v"] < 8.5


@pytest.mark.rig("sitl")
def test_the_same_for_a_person(rover, port):
    result = rover("status", "--port", port)
    assert result.code == 0
    assert "state           disarmed\n" in result.out


@pytest.mark.rig("sitl")
def test_the_doctor_shakes_hands(rover, port):
    checks = json.loads(rover("doctor", "--port", port, "--json").out)["checks"]
    assert checks[-1]["name"] == "firmware"
    assert checks[-1]["ok"]
    assert "Sitl" in checks[-1]["detail"]
