"""The whole table of phases, cell by cell and by what must hold for all of it."""

from __future__ import annotations

from itertools import product

import pytest
from rover.mission.phase import PHASES, TABLE, Event, Phase, transition

# The phases in which the rover is armed.
DRIVEN = (Phase.LOOK, Phase.SEEK, Phase.DECIDE, Phase.DRIVE, Phase.INSPECT, Phase.HOME)

# Every cell that means something; the test below holds all others to be empty.
MEANT: dict[tuple[Phase, Event], Phase] = {
    (Phase.START, Event.CONNECTED): Phase.LOOK,
    (Phase.LOOK, Event.LOOKED): Phase.DECIDE,
    (Phase.DECIDE, Event.SET_OUT): Phase.DRIVE,
    (Phase.DRIVE, Event.ARRIVED): Phase.INSPECT,
    (Phase.DRIVE, Event.SHOWN): Phase.DECIDE,
    (Phase.DRIVE, Event.BLOCKED): Phase.DECIDE,
    (Phase.INSPECT, Event.INSPECTED): Phase.DECIDE,
    (Phase.LOOK, Event.BLIND): Phase.LOOK,
    (Phase.SEEK, Event.BLIND): Phase.SEEK,
    (Phase.DRIVE, Event.BLIND): Phase.DECIDE,
    (Phase.INSPECT, Event.BLIND): Phase.INSPECT,
    (Phase.SEEK, Event.PLACED): Phase.DECIDE,
    (Phase.HALTED, Event.REARMED): Phase.DECIDE,
    **{(phase, Event.ASTRAY): Phase.SEEK for phase in DRIVEN if phase is not Phase.SEEK},
    **{(phase, Event.STALLED): Phase.LOOK for phase in DRIVEN if phase is not Phase.SEEK},
    (Phase.SEEK, Event.STALLED): Phase.SEEK,
    (Phase.HOME, Event.BLIND): Phase.DECIDE,
    **{(phase, Event.RETURN): Phase.HOME for phase in DRIVEN if phase is not Phase.SEEK},
    **{(phase, Event.PAUSE): Phase.PAUSED for phase in DRIVEN},
    (Phase.PAUSED, Event.GO): Phase.DECIDE,
    **{(phase, Event.STOPPED): Phase.HALTED for phase in (*DRIVEN, Phase.PAUSED)},
    **{(phase, Event.ENDED): Phase.FINISHED for phase in (Phase.START, *DRIVEN, Phase.PAUSED, Phase.HALTED)},
}


def test_every_event_has_one_row_and_every_phase_a_column() -> None:
    assert set(TABLE) == set(Event)
    assert all(len(row) == len(PHASES) for row in TABLE.values())


@pytest.mark.parametrize(("phase", "event"), list(product(Phase, Event)))
def test_each_cell_is_what_it_is_meant_to_be(phase: Phase, event: Event) -> None:
    assert transition(phase, event) is MEANT.get((phase, event))


def test_nothing_leads_out_of_the_end_and_nothing_back_to_the_start() -> None:
    assert not any(transition(Phase.FINISHED, event) for event in Event)
    assert Phase.START not in {transition(phase, event) for phase, event in product(Phase, Event)}


def test_every_phase_can_be_reached_and_can_reach_the_end() -> None:
    ways = {phase: {transition(phase, event) for event in Event} - {None} for phase in Phase}

    def reached(first: Phase) -> set[Phase | None]:
        found: set[Phase | None] = {first}
        while more := {after for phase in found if phase for after in ways[phase]} - found:
            found |= more
        return found

    assert reached(Phase.START) == set(Phase)
    assert all(Phase.FINISHED in reached(phase) for phase in Phase)


def test_only_rearming_or_the_end_leads_out_of_a_stop_by_the_firmware() -> None:
    assert {event for event in Event if transition(Phase.HALTED, event)} == {Event.REARMED, Event.ENDED}


def test_the_rover_only_sets_out_from_a_decision() -> None:
    ways = [(phase, event) for phase, event in product(Phase, Event) if transition(phase, event) is Phase.DRIVE]
    assert ways == [(Phase.DECIDE, Event.SET_OUT)]
