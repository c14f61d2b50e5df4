"""No state of a mission lasts without motion, a decision, or an end with a reason."""

from __future__ import annotations

import numpy as np
import pytest
from rover.link.words import FaultCode, MotorState, StopCause
from rover.mission.progress import END_AFTER_S, LOOK_AFTER_S, MAX_IDLE_DRIVES, MAX_LOOKS, Duty, Progress
from rover.outcome import RunStatus

from companion.tests.mission.imagined_rover import CYCLE, Imagined, ImaginedRover, a_mission

# What may be so, each drawn anew every few seconds.
ANYTHING = {
    "sigma": (0.005, 0.03, 0.049, 0.051, 0.07, 0.081, 0.3, 5.0),
    "frames": (True, True, True, False),
    "shutter": (False, False, False, True),
    "shows": (True, True, False),
    "wheels": (True, True, True, False),
    "speaks": (True, True, True, False),
    "state": (*[MotorState.ARMED] * 6, *MotorState),
    "cause": (*[StopCause.SONAR_GUARD] * 3, *StopCause),
    "faults": (*[()] * 6, *((fault.value,) for fault in FaultCode)),
    "volts": (7.6, 7.6, 7.6, 6.25),
}


@pytest.mark.parametrize("seed", range(40))
def test_whatever_comes_the_rover_moves_decides_or_ends(seed: int) -> None:
    random = np.random.default_rng(seed)
    rover = ImaginedRover()
    since, then = 0.0, (rover.survey.phase, 0)
    while rover.survey.outcome is None and rover.now < 300.0:
        for name, values in ANYTHING.items():
            if random.random() < 0.01:
                rover.become(**{name: values[random.integers(len(values))]})
        rover.step()
        state = (rover.survey.phase, len(rover.notes))  # a decision leaves a line
        if rover.moved or state != then:
            since, then = rover.now, state
        assert rover.now - since <= END_AFTER_S + 2.0 * CYCLE, rover.notes
    if rover.survey.outcome is not None:
        assert rover.survey.outcome.reason


@pytest.mark.parametrize("sigma", [0.051, 0.07, 0.3])
def test_a_place_that_stays_too_vague_to_map_is_looked_around_from_and_then_given_up(sigma: float) -> None:
    rover = ImaginedRover(world=Imagined(sigma=sigma)).run(120.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.PARTIAL
    assert f"1σ of {sigma:.2f} m" in rover.survey.outcome.reason
    assert "looking around" in rover.notes[0]


@pytest.mark.parametrize(
    ("world", "why"),
    [
        (Imagined(frames=False), "camera"),
        (Imagined(shutter=True), "camera"),
        (Imagined(speaks=False), "does not tell its state"),
        (Imagined(sigma=5.0), "does not know where it is"),
        (Imagined(wheels=False), ""),
        (Imagined(shows=False), "are required"),
        (Imagined(state=MotorState.STOPPING), "does not let it go on"),
        (Imagined(state=MotorState.LATCHED, cause=StopCause.SONAR_GUARD), "SonarGuard"),
        (Imagined(state=MotorState.DISARMED, cause=StopCause.DISARM), "Disarm"),
        (Imagined(state="Unknown9"), ""),
    ],
)
def test_a_world_in_which_nothing_ever_changes_ends_the_mission_with_the_reason(world: Imagined, why: str) -> None:
    rover = ImaginedRover(world=world).run(300.0)
    assert rover.survey.outcome is not None, rover.notes
    assert rover.survey.outcome.status is not RunStatus.DONE
    assert why in rover.survey.outcome.reason


def test_a_rover_that_knows_of_nowhere_to_go_looks_around_before_it_gives_up() -> None:
    rover = ImaginedRover(world=Imagined(shows=False)).run(60.0)
    looks = [n for n, note in enumerate(rover.notes) if "looks around" in note]
    assert looks
    assert looks[0] < len(rover.notes) - 1


def test_what_the_look_around_shows_is_gone_on_with() -> None:
    rover = ImaginedRover(world=Imagined(shows=False))
    while not any("looks around" in note for note in rover.notes):
        rover.step()
    rover.become(shows=True)
    rover.run(300.0)
    assert rover.perception.grid.seen.mean() > 0.9
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE


def test_a_mission_that_goes_well_is_not_disturbed() -> None:
    rover = ImaginedRover(a_mission(mission={"goals": [[1.2, 1.2]]})).run(300.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE
    assert not any("looks around" in note for note in rover.notes)


def test_the_rule_by_itself_looks_first_and_ends_then() -> None:
    rule, now, duties = Progress(), 0.0, []
    while Duty.END not in duties:
        now += CYCLE
        duty = rule.check(now, 0.0, may_turn=True)
        if duty is Duty.LOOK:
            rule.looks_around(now)
        duties.append(duty)
    assert duties.count(Duty.LOOK) == MAX_LOOKS
    assert now == pytest.approx((MAX_LOOKS + 1) * LOOK_AFTER_S, abs=1.0)


def test_drives_that_bring_nothing_are_counted() -> None:
    rule = Progress()
    rule.check(0.0, 0.0, may_turn=True)
    for gain in [*range(10), *[9] * MAX_IDLE_DRIVES]:
        assert rule.check(0.0, 0.0, may_turn=True) is Duty.NOTHING
        rule.drives(0.0, gain)
    rule.drives(0.0, 9)
    assert rule.check(0.0, 0.0, may_turn=True) is Duty.END
    assert "drives" in rule.reason("")
