"""What the rover is about, and what moves it on: one table of phase and event.

The table is the whole truth about the phases of a mission. Whether an event happens is decided in `survey`, as is what
the rover does in a phase; nothing else changes the phase.
"""

from __future__ import annotations

from enum import Enum, auto

from rover.str_enum import StrEnum


class Phase(StrEnum):
    """What the rover is about; the live display shows the value."""

    # The firmware has not been heard yet.
    START = "start"
    # A whole turn at the launch.
    LOOK = "look"
    # The rover does not know where it is and looks around for ground that it knows.
    SEEK = "seek"
    # At rest, until the next picture is mapped: where to next?
    DECIDE = "decide"
    DRIVE = "drive"
    # At rest in front of a goal.
    INSPECT = "inspect"
    # On the way back to the launch.
    HOME = "home"
    # At rest until the operator says what to do.
    PAUSED = "paused"
    # Stopped by the firmware.
    HALTED = "halted"
    FINISHED = "finished"


class Event(Enum):
    """What moves the mission on. All but the first and STOPPED happen while the rover is at rest."""

    # The firmware is there; the rover is armed.
    CONNECTED = auto()
    # The look around is over.
    LOOKED = auto()
    # A path has been chosen.
    SET_OUT = auto()
    # The drive ended at a goal's inspection pose.
    ARRIVED = auto()
    # The drive ended at a viewpoint: its ground has been shown.
    SHOWN = auto()
    # The goal has been looked at for long enough.
    INSPECTED = auto()
    # The rover has braked before ground that is no longer free.
    BLOCKED = auto()
    # The camera shows nothing.
    BLIND = auto()
    # The pose is too uncertain to drive on.
    ASTRAY = auto()
    # The pose is certain again.
    PLACED = auto()
    # The rover has stood for too long, or knows of nowhere to go: perhaps other headings show more.
    STALLED = auto()
    # A way back to the launch has been chosen.
    RETURN = auto()
    # The operator wants the rover to stand and wait, or to go on.
    PAUSE = auto()
    GO = auto()
    # The firmware has stopped the rover.
    STOPPED = auto()
    # The firmware accepts motion again.
    REARMED = auto()
    # There is an outcome.
    ENDED = auto()


PHASES = tuple(Phase)

NONE = None
LOOK, SEEK, DECIDE, DRIVE = Phase.LOOK, Phase.SEEK, Phase.DECIDE, Phase.DRIVE
INSPECT, HOME, PAUSED = Phase.INSPECT, Phase.HOME, Phase.PAUSED
HALTED, FINISH = Phase.HALTED, Phase.FINISHED

# A row an event, a column a phase. NONE: the event means nothing in that phase. A phase that is entered from itself
# begins anew: so a blind rover's look around or inspection waits for pictures.
TABLE: dict[Event, tuple[Phase | None, ...]] = {
    #                 START    LOOK     SEEK     DECIDE   DRIVE    INSPECT  HOME     PAUSED   HALTED   FINISHED
    Event.CONNECTED:  (LOOK,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE),
    Event.LOOKED:     (NONE,    DECIDE,  NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE),
    Event.SET_OUT:    (NONE,    NONE,    NONE,    DRIVE,   NONE,    NONE,    NONE,    NONE,    NONE,    NONE),
    Event.ARRIVED:    (NONE,    NONE,    NONE,    NONE,    INSPECT, NONE,    NONE,    NONE,    NONE,    NONE),
    Event.SHOWN:      (NONE,    NONE,    NONE,    NONE,    DECIDE,  NONE,    NONE,    NONE,    NONE,    NONE),
    Event.INSPECTED:  (NONE,    NONE,    NONE,    NONE,    NONE,    DECIDE,  NONE,    NONE,    NONE,    NONE),
    Event.BLOCKED:    (NONE,    NONE,    NONE,    NONE,    DECIDE,  NONE,    NONE,    NONE,    NONE,    NONE),
    Event.BLIND:      (NONE,    LOOK,    SEEK,    NONE,    DECIDE,  INSPECT, DECIDE,  NONE,    NONE,    NONE),
    Event.ASTRAY:     (NONE,    SEEK,    NONE,    SEEK,    SEEK,    SEEK,    SEEK,    NONE,    NONE,    NONE),
    Event.PLACED:     (NONE,    NONE,    DECIDE,  NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE),
    Event.STALLED:    (NONE,    LOOK,    SEEK,    LOOK,    LOOK,    LOOK,    LOOK,    NONE,    NONE,    NONE),
    Event.RETURN:     (NONE,    HOME,    NONE,    HOME,    HOME,    HOME,    HOME,    NONE,    NONE,    NONE),
    Event.PAUSE:      (NONE,    PAUSED,  PAUSED,  PAUSED,  PAUSED,  PAUSED,  PAUSED,  NONE,    NONE,    NONE),
    Event.GO:         (NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    DECIDE,  NONE,    NONE),
    Event.STOPPED:    (NONE,    HALTED,  HALTED,  HALTED,  HALTED,  HALTED,  HALTED,  HALTED,  NONE,    NONE),
    Event.REARMED:    (NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    NONE,    DECIDE,  NONE),
    Event.ENDED:      (FINISH,  FINISH,  FINISH,  FINISH,  FINISH,  FINISH,  FINISH,  FINISH,  FINISH,  NONE),
}  # fmt: skip


def transition(phase: Phase, event: Event) -> Phase | None:
    """The phase that an event leads to; None when it means nothing in this one."""
    return TABLE[event][PHASES.index(phase)]
