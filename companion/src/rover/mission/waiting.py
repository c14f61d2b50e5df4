"""What a rover that stands still is waiting for, in words for the operator."""

from __future__ import annotations

from rover.mission.phase import Phase

WAITING_FOR = {
    Phase.START: "the firmware does not tell its state",
    Phase.LOOK: "it should look around and does not turn",
    Phase.SEEK: "it looks for ground that it knows and does not turn",
    Phase.DECIDE: "no picture shows ground to decide on",
    Phase.DRIVE: "it should drive and does not move",
    Phase.INSPECT: "it should inspect a goal",
    Phase.HOME: "it should drive home and does not move",
    Phase.PAUSED: "it was told to wait",
    Phase.HALTED: "the firmware has stopped it and does not let it go on",
    Phase.FINISHED: "the mission is over",
}


def waiting_for(phase: Phase, blind: bool, placed: bool, sigma: float, cause: str) -> str:
    """`sigma`: of the place among the ground around, metres; `cause`: of the firmware's last stop."""
    if phase is Phase.HALTED:
        return f"{WAITING_FOR[phase]} ({cause})"
    if phase in (Phase.START, Phase.PAUSED):
        return WAITING_FOR[phase]
    if blind:
        return "the camera shows nothing"
    if not placed:
        return f"the place is not known well enough to map what the camera shows (1σ of {sigma:.2f} m)"
    return WAITING_FOR[phase]
