"""A board on a port, in real time and in its test mode: what can be tested without a world around it.

`pytest hil_tests/tests/test_device.py --rig device --port /dev/ttyACM0` takes a real one. Otherwise a free-running sitl
rig stands in for it, behind a port that speaks the same.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from rover.cli.main import invoke
from rover.errors import PreflightFailed
from rover_hil.device.bench import TEST_KEY, TEST_MODE_FLAG, Bench
from rover_hil.firmware_process import find_binary
from rover_hil.testing.served import ServedRig
from rover_protocol import messages

DEAD_MAN, GAIN_POSITION = 1, 45
pytestmark = pytest.mark.rig("device")


@pytest.fixture(scope="module")
def port(request: pytest.FixtureRequest) -> Iterator[str]:
    """Of the board that was named, or of a stand-in."""
    given = request.config.getoption("--port")
    if given is not None:
        yield given
        return
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running = ServedRig(str(Path(__file__).resolve().parent / "missions" / "look.toml"), "--free-run")
    yield running.port
    running.stop()


@pytest.fixture
def bench(port: str) -> Iterator[Bench]:
    """The board, disarmed."""
    made = Bench(port)
    made.settle()
    yield made
    made.close()


@pytest.fixture
def tested(bench: Bench) -> Bench:
    """The board in test mode."""
    bench.enter_test_mode()
    return bench


def test_the_handshake_is_answered_with_the_same_schema(bench: Bench) -> None:
    build = bench.hello(session=0x1234)
    assert (build["accepted"], build["session"]) == (1, 0x1234)
    assert bench.talk.all("HelloReply")[-1]["schema_hash"] == messages.SCHEMA_HASH


def test_another_schema_is_refused_and_arming_with_it(tested: Bench) -> None:
    assert tested.hello(flip=1)["accepted"] == 0
    tested.send_arm()
    refused = tested.talk.until("Fault", lambda m: m["code"] == "ArmRefused", 1.0)
    assert refused["detail"] & 1
    assert tested.talk.all("State")[-1]["state"] in ("Disarmed", "Latched")
    assert tested.hello()["accepted"] == 1


def test_telemetry_comes_at_its_rates_by_the_firmwares_own_clock(bench: Bench) -> None:
    bench.talk.wait(1.0)
    times = [message["time"] for message in bench.talk.all("WheelTicks")]
    assert len(times) > 20
    periods = {(b - a) & 0xFFFF for a, b in itertools.pairwise(times)}
    assert periods == {20}
    for name in ("State", "MotionStatus", "OdometryHeading", "Velocity", "Battery", "LinkStatistics"):
        assert bench.talk.all(name), name


def test_a_telemetry_rate_can_be_changed_and_switched_off(bench: Bench) -> None:
    wheels = messages.WheelTicks.ID
    bench.talk.send("TelemetryRate", message=wheels, period=100)
    bench.talk.wait(0.3)
    bench.talk.forget()
    bench.talk.wait(0.8)
    times = [message["time"] for message in bench.talk.all("WheelTicks")]
    assert {(b - a) & 0xFFFF for a, b in itertools.pairwise(times)} == {100}
    bench.talk.send("TelemetryRate", message=wheels, period=0)
    bench.talk.wait(0.3)
    bench.talk.forget()
    bench.talk.wait(0.4)
    assert bench.talk.all("WheelTicks") == []
    bench.talk.send("TelemetryRate", message=wheels, period=20)


def test_a_parameter_is_read_set_and_refused_out_of_its_range(bench: Bench) -> None:
    def ask(name: str, **values: int) -> tuple[int, str]:
        bench.talk.send(name, **values)
        answer = bench.talk.until("ParameterValue", lambda m: m["identifier"] == values["identifier"], 1.0)
        return answer["value"], answer["status"]

    before, status = ask("ParameterGet", identifier=GAIN_POSITION)
    assert status == "Ok"
    assert ask("ParameterSet", identifier=GAIN_POSITION, value=before + 1) == (before + 1, "Ok")
    assert ask("ParameterSet", identifier=GAIN_POSITION, value=-1) == (before + 1, "OutOfRange")
    assert ask("ParameterSet", identifier=GAIN_POSITION, value=before) == (before, "Ok")
    assert ask("ParameterGet", identifier=999)[1] == "UnknownParameter"


def test_test_mode_needs_its_key_and_ends_on_command(bench: Bench) -> None:
    bench.talk.send("TestMode", enable=1, key=TEST_KEY ^ 1)
    bench.talk.wait(0.3)
    assert not bench.talk.all("State")[-1]["flags"] & TEST_MODE_FLAG
    bench.enter_test_mode()
    bench.talk.send("TestMode", enable=0)
    bench.talk.until("State", lambda m: not m["flags"] & TEST_MODE_FLAG, 1.0)


def test_it_arms_drives_and_comes_to_rest_where_it_was_told(tested: Bench) -> None:
    start = tested.talk.until("OdometryPosition", lambda m: True, 1.0)["x"]
    begin = tested.talk.until("ReferenceDistance", lambda m: True, 1.0)["travel"]
    tested.arm()
    length = tested.drive(0.3)
    tested.state("Moving")
    tested.state("Armed", seconds=5.0)
    tested.talk.wait(0.2)
    assert tested.talk.all("ReferenceDistance")[-1]["travel"] - begin == pytest.approx(length * 1e5, abs=3)
    moved = tested.talk.all("OdometryPosition")[-1]["x"] - start
    assert abs(moved) <= length * 1e5 + 60
    tested.talk.send("Disarm")
    tested.state("Disarmed")


def test_without_keep_alives_it_stops_and_latches(tested: Bench) -> None:
    tested.arm()
    tested.alive = False
    assert tested.state("Latched")["cause"] == "DeadMan"


@pytest.mark.parametrize(("command", "cause"), [("Stop", "StopCommand"), ("EmergencyStop", "EmergencyCommand")])
def test_a_stop_on_the_way_latches_until_a_new_token_comes(tested: Bench, command: str, cause: str) -> None:
    tested.arm()
    tested.drive(2.0)
    tested.state("Moving")
    tested.talk.send(command, reason=9)
    latched = tested.state("Latched")
    assert (latched["cause"], latched["cause_detail"]) == (cause, 9)
    tested.send_arm(step=0)
    tested.talk.wait(0.3)
    assert tested.talk.all("State")[-1]["state"] == "Latched"
    tested.arm()


def test_something_near_on_the_way_stops_it(tested: Bench) -> None:
    tested.arm()
    tested.drive(3.0)
    tested.state("Moving")
    tested.echoes_m = dict.fromkeys((0, 1, 2), 0.05)
    assert tested.state("Latched", seconds=3.0)["cause"] == "SonarGuard"


def test_a_low_battery_stops_it_and_arming_is_refused(tested: Bench) -> None:
    tested.arm()
    tested.battery_v = 5.5
    assert tested.state("Latched", seconds=3.0)["cause"] == "LowBattery"
    tested.send_arm()
    assert tested.talk.until("Fault", lambda m: m["code"] == "ArmRefused", 1.0)["detail"] & 4


def test_the_emergency_stop_input_stops_it_and_arming_is_refused(tested: Bench) -> None:
    tested.arm()
    tested.emergency_stop = True
    assert tested.state("Latched")["cause"] == "EmergencyInput"
    tested.send_arm()
    assert tested.talk.until("Fault", lambda m: m["code"] == "ArmRefused", 1.0)["detail"] & 2


def test_wheels_that_do_not_follow_cut_the_motors(tested: Bench) -> None:
    tested.arm()
    tested.wheels_follow = False
    tested.drive(2.0)
    stopped = tested.state("Latched", seconds=4.0)
    assert stopped["cause"] in ("Stall", "EncoderFault")


def test_an_injector_that_falls_silent_ends_the_test_mode(tested: Bench) -> None:
    tested.arm()
    tested.injecting = False
    stopped = tested.state("Latched")
    assert stopped["cause"] == "InjectorSilent"
    assert not stopped["flags"] & TEST_MODE_FLAG


def test_a_lost_link_stops_it_and_the_next_companion_finds_it_latched(bench: Bench, port: str) -> None:
    bench.enter_test_mode()
    bench.arm()
    bench.talk.close()
    other = Bench(port)
    other.talk.wait(1.0)
    other.hello()
    latched = other.talk.until("State", lambda m: True, 1.0)
    assert latched["state"] == "Latched"
    assert latched["cause"] in ("DeadMan", "InjectorSilent")
    bench.talk = other.talk
    bench.talk.work = lambda: None


def test_a_restart_is_told(bench: Bench) -> None:
    bench.talk.send("Reboot", magic=0x5242_4F54, session=bench.session)
    bench.talk.wait(1.5)
    assert bench.hello()["reset_cause"] == "Software"


# A replay in real time feeds the sensors without a gap of 25 ms; a machine that is busy may not manage at once.
ATTEMPTS = 3


def test_a_recorded_mission_replays_on_it(port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mission = Path(__file__).resolve().parent / "missions" / "look.toml"
    assert invoke(["run", str(mission), "--seed", "3", "--out", str(tmp_path), "--force", "--quiet"]) in (0, 8)
    capsys.readouterr()
    log = str(tmp_path / "mission.mcap")
    for _ in range(ATTEMPTS):
        code = invoke(["replay", log, "--rig", "device", "--port", port, "--json", "--quiet"])
        result = json.loads(capsys.readouterr().out)
        if "InjectorSilent" not in str(result["first_difference"]):
            break
    assert code == 0
    assert result["identical"]
    assert result["parts"]["firmware"]["compared"] >= 5
