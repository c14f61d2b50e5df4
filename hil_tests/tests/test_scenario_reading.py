"""Scenario files: what is wrong in one is one line with file and key."""

from __future__ import annotations

from pathlib import Path

import pytest
from rover.errors import BadInput
from rover_hil.scenario.condition import parse_condition
from rover_hil.scenario.language import START
from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play

HEAD = """
name = "n"
description = "d"
rigs = ["sitl"]
"""
DRIVE = """
[drive]
steps = [{ forward_m = 1.0 }, { turn_deg = -90 }]
repeat = 2
"""
INJECT = """
[[inject]]
fault = "serial-cut"
when = "state == Moving and travelled_m > 0.3"
"""
EXPECT = """
[[expect]]
within_s = 0.35
state = "Latched"
"""
END = """
[end]
state = "Latched"
"""
GOOD = HEAD + DRIVE + INJECT + EXPECT + END


def read(folder: Path, text: str):
    file = folder / "one.toml"
    file.write_text(text)
    return load_scenario(file)


def test_a_file_becomes_moves_faults_and_expectations(tmp_path: Path) -> None:
    scenario = read(tmp_path, GOOD)
    assert [(move.kind, move.amount) for move in scenario.drive.moves] == [("forward_m", 1.0), ("turn_deg", -90.0)] * 2
    assert scenario.injections[0].parameters == {"direction": "both"}
    assert (scenario.expectations[0].after, scenario.expectations[0].within) == ("serial-cut", 0.35)


def test_without_a_fault_an_expectation_counts_from_the_start(tmp_path: Path) -> None:
    assert read(tmp_path, HEAD + DRIVE + EXPECT + END).expectations[0].after == START


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('name = "n"', 'nam = "n"', "nam: unknown key; did you mean name?"),
        ('name = "n"', "", "name: missing"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\nspeed = 3', "speed: unknown key; "),
        ('rigs = ["sitl"]', 'rigs = ["simulator"]', "rigs: 'simulator' is not one of sitl, emulator, device"),
        ('rigs = ["sitl"]', "rigs = []", "rigs: must name at least one"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\nseed = 1.5', "seed: must be a whole number, not 1.5"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\ntransport = "usb"', "transport: 'usb' is not one of serial, can"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\ntransport = "can"', "does not exist on transport 'can'"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\nmax_duration_s = 0', "max_duration_s: 0 lies outside 0.5 to 600 s"),
        ("forward_m = 1.0", "forwards_m = 1.0", "[drive.steps 1] must be one of { forward_m"),
        ("forward_m = 1.0", 'forward_m = "far"', "[drive.steps 1] forward_m: must be a number in m, not 'far'"),
        ("repeat = 2", "repeat = 2\nreverse = true", "[drive] reverse: unknown key"),
        ("repeat = 2", "repeat = 2\narm = 1", "[drive] arm: must be true or false, not 1"),
        ("repeat = 2", "repeat = 2\narm = false", "nothing drives unarmed"),
        ("serial-cut", "serial-cutt", "[inject 1] fault: 'serial-cutt' is not one of"),
        ("serial-cut", "camera-frozen", "a scripted drive does not notice it"),
        ("serial-cut", "bit-errors", "[inject 1] rate: missing"),
        ("serial-cut", "companion-killed", None),
        ("state == Moving", "state = Moving", "[inject 1] when: condition 'state = Moving and travelled_m > 0.3'"),
        ("state == Moving", "state == moving", "state is never 'moving'; it is one of Boot, Disarmed"),
        ("travelled_m", "distance", "'distance' is not observed; there is"),
        ('fault = "serial-cut"', 'fault = "serial-cut"\nat_s = 1', "when: stands beside at_s or after"),
        ('fault = "serial-cut"', 'fault = "stop-command"\nduration_s = 1', "stop-command happens once"),
        ('fault = "serial-cut"', 'fault = "serial-cut"\nname = "start"', "[inject 1] name: 'start' is taken"),
        ("within_s = 0.35", "", "[expect 1] within_s: missing"),
        ("within_s = 0.35", "within_s = 0.35\nnot_before_s = 1", "not_before_s: must be less than within_s"),
        ("within_s = 0.35", 'within_s = 0.35\nafter = "stop"', "[expect 1] after: 'stop' is not one of start"),
        ("within_s = 0.35", 'within_s = 0.35\ncause = "Deadman"', "[expect 1] cause: 'Deadman' is not one of"),
        ("within_s = 0.35", 'within_s = 0.35\nfault = "Fire"', "the protocol has no fault of that name"),
        (EXPECT, "", "expect: missing: a scenario says what must be observed"),
        (EXPECT, "\n[[expect]]\nwithin_s = 1\n", "[expect 1] expects nothing"),
        (END, "", "[end] state: missing: a scenario says in which state it ends"),
        (END, END + "speed = 1\n", "[end] speed: unknown key"),
        (END, END + "[plant.wheels]\nmass = 1\n", "[plant] wheels: unknown key; known are drive, battery"),
        (END, END + "[field]\nlaunch = [0, 0, 0]\n", "[field] launch: lies nearer than the rover's radius"),
    ],
)
def test_what_is_wrong_is_one_line_with_file_and_key(tmp_path: Path, before: str, after: str, said: str | None) -> None:
    assert before in GOOD
    text = GOOD.replace(before, after, 1)
    if said is None:
        read(tmp_path, text)
        return
    with pytest.raises(BadInput) as error:
        read(tmp_path, text)
    assert said in str(error.value)
    assert str(error.value).startswith(str(tmp_path / "one.toml"))
    assert "\n" not in str(error.value)


def test_a_fault_that_cannot_exist_on_a_rig_is_refused_there(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"'motor-stalled' can't exist on device: take that out of rigs"):
        read(
            tmp_path,
            GOOD.replace('["sitl"]', '["sitl", "device"]').replace("serial-cut", 'motor-stalled"\nwheel = "left'),
        )


def test_a_file_that_is_no_toml_or_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="not valid TOML"):
        read(tmp_path, "name = ")
    with pytest.raises(BadInput, match="no such file"):
        load_scenario(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("state == Moving", True),
        ("state != Moving", False),
        ("speed > 0.2 and speed <= 0.25", True),
        ("speed > 0.3 or powered", True),
        ("not powered or (speed < 0.1 and state == Moving)", False),
        ("fault.DeadMan", False),
        ("count.DeadMan == 0", True),
        ("count.Stall >= 2", True),
    ],
)
def test_conditions_mean_what_they_say(text: str, expected: bool) -> None:
    seen: dict[str, float | str | bool] = {"state": "Moving", "speed": 0.25, "powered": True, "count.Stall": 2}
    assert parse_condition(text)(seen) is expected


@pytest.mark.parametrize(
    "text", ["", "speed", "speed >", "speed > fast", "(powered", "powered powered", "state > Moving", "fault.Fire", "%"]
)
def test_a_condition_that_makes_no_sense_is_refused(text: str) -> None:
    with pytest.raises(BadInput, match="condition"):
        parse_condition(text)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("camera-frozen", "serial-cut", "'serial-cut', which is for scripted drives; in a mission there is"),
        ('rigs = ["sitl"]', 'rigs = ["sitl"]\ntransport = "can"', "[drive] mission: is driven over serial"),
        ("[end]", "[field]\nwidth_m = 3\n[end]", "field: has no meaning beside drive.mission"),
        ('mission = "demo"', 'mission = "demo"\nspeed = 0.2', "[drive] speed: unknown key; known are mission"),
        ("within_s = 0.35", "within_s = 0.35\nfrom_s = 1", "from_s: must be less than within_s"),
    ],
)
def test_what_a_whole_mission_cannot_have_is_one_line(tmp_path: Path, before: str, after: str, said: str) -> None:
    mission = HEAD + '[drive]\nmission = "demo"\n' + INJECT.replace("serial-cut", "camera-frozen") + EXPECT + END
    assert read(tmp_path, mission).mission == "demo"
    assert before in mission
    with pytest.raises(BadInput) as error:
        read(tmp_path, mission.replace(before, after, 1))
    assert said in str(error.value)


def test_a_mission_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"none\.toml"):
        play(read(tmp_path, HEAD + '[drive]\nmission = "none.toml"\n' + EXPECT + END), "sitl")


@pytest.mark.parametrize("value", [-1, 256, 99_999_999])
def test_a_raw_value_that_does_not_fit_its_field_is_said_before_anything_runs(value: int, tmp_path: Path) -> None:
    sent = f'\n[[inject]]\nfault = "send"\nmessage = ["KeepAlive"]\nvalues = {{ counter = {value} }}\nat_s = 0.5\n'
    with pytest.raises(BadInput, match="does not fit 8 bits"):
        read(tmp_path, HEAD + DRIVE + sent + EXPECT + END)
