"""What a firmware says of itself, as a JSON document and in words: of a port or of a mission."""

from __future__ import annotations

from typing import Any

from rover.link.handshake import Identity
from rover.link.statistics import LinkFigures
from rover.link.telemetry import Battery, FirmwareState

CAUSES = {
    "None": "nothing has stopped it since it started",
    "StopCommand": "it was told to stop",
    "EmergencyCommand": "it was told to stop at once",
    "EmergencyInput": "the emergency-stop button was pressed",
    "DeadMan": "the dead-man stopped it, nothing was heard from the companion",
    "SonarGuard": "the sonar guard stopped it, something was too close ahead",
    "LowBattery": "the battery was too low",
    "Stall": "a wheel did not turn although it was driven",
    "EncoderFault": "a wheel encoder told nonsense",
    "Underrun": "the motion queue ran empty while it moved",
    "Disarm": "it was disarmed",
    "Internal": "the firmware met an error of its own",
    "Bumper": "its bumper touched something",
    "SensorLost": "a sonar no longer answered while it drove forward",
    "InjectorSilent": "in test mode, what plays its sensors fell silent",
}


def in_words(state: FirmwareState) -> str:
    """State and cause of the last stop, as one phrase an operator understands."""
    cause = CAUSES.get(state.cause, f"cause {state.cause}, which this version does not know")
    name = state.state.lower()
    if state.state in ("Latched", "Stopping"):
        return f"{name}: {cause}"
    return name if state.cause == "None" else f"{name}; last stop: {cause}"


def firmware_document(
    port: str, identity: Identity, state: FirmwareState, battery: Battery | None, figures: LinkFigures
) -> dict[str, Any]:
    """The document of `rover status --json`."""
    return {
        "port": port,
        "firmware": identity.version,
        "board": identity.board,
        "git_hash": identity.git_hash,
        "schema_hash": f"{identity.schema_hash:08x}",
        "reset_cause": identity.reset_cause,
        "state": state.state,
        "cause": state.cause,
        "cause_detail": state.cause_detail,
        "meaning": in_words(state),
        "faults": list(state.faults),
        "emergency_input": state.emergency_input,
        "bumper": state.bumper,
        "moving": state.moving,
        "powered": state.powered,
        "battery_v": None if battery is None else round(battery.voltage, 3),
        "round_trip_ms": round(figures.round_trip_median * 1e3, 3),
    }
